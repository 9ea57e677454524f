"""What the doctor finds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from enum import Enum


class Severity(Enum):
    """How much a finding matters."""

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"


@dataclass(frozen=True)
class Finding:
    """One place in a user's file.

    Attributes:
        file: the file.
        line: the line, from 1 on.
        rule: short name of what was found.
        severity: error if it does not work on this engine, warning if it works differently, note if
            it works but could work better.
        text: what was found, and what to do.
    """

    file: str
    line: int
    rule: str
    severity: Severity
    text: str

    @property
    def is_bad(self) -> bool:
        """Whether the finding is more than a note."""
        return self.severity is not Severity.NOTE


@dataclass(frozen=True)
class Report:
    """What was found in a workspace.

    Attributes:
        findings: all findings.
        packages: names of the packages that were examined.
        states: number of state classes.
        behaviors: number of behavior classes.
        constructed: number of states and behaviors that were constructed.
    """

    findings: tuple[Finding, ...]
    packages: tuple[str, ...]
    states: int
    behaviors: int
    constructed: int

    def as_text(self, folder: str) -> str:
        """Return one line for each finding, with files relative to a folder, and a summary."""
        lines = [
            f"{_relative(f.file, folder)}:{f.line}: {f.severity.value} [{f.rule}] {f.text}"
            for f in self.findings
        ]
        counts = ", ".join(f"{self.count(severity)} {severity.value}s" for severity in Severity)
        return "\n".join(
            [
                *lines,
                f"{len(self.packages)} packages, {self.states} states, {self.behaviors} behaviors; "
                f"{self.constructed} constructed: {counts}",
            ]
        )

    def as_dict(self) -> dict[str, object]:
        """Return the report for JSON."""
        findings = [{**asdict(f), "severity": f.severity.value} for f in self.findings]
        return {**asdict(self), "findings": findings}

    def count(self, severity: Severity) -> int:
        """Return how many findings have a severity."""
        return sum(finding.severity is severity for finding in self.findings)


def sorted_findings(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Return findings by file and line, each once."""
    unique = set(findings)
    return tuple(sorted(unique, key=lambda f: (f.file, f.line, f.rule, f.text)))


def _relative(file: str, folder: str) -> str:
    return file.removeprefix(f"{folder.rstrip('/')}/")
