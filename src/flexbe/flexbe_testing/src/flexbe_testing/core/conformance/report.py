"""Print scenarios and findings."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Sequence

from flexbe_testing.core.conformance.scenario import Finding, Scenario, Verdict


def listing(scenarios: Sequence[Scenario]) -> str:
    """Return the scenarios with what is required, one per line."""
    width = max(len(scenario.name) for scenario in scenarios)
    return "\n".join(
        f"{scenario.name:{width}}  {scenario.section:5}  {scenario.required}"
        for scenario in scenarios
    )


def progress(finding: Finding) -> str:
    """Return one line about a finding that was just made."""
    reason = f": {finding.reason}" if finding.reason else ""
    return f"{finding.verdict.value:10} {finding.scenario.name}{reason}"


def table(findings: Sequence[Finding]) -> str:
    """Return a table of all findings, and their count."""
    heads = ("scenario", "section", "verdict", "required")
    rows = [(f.scenario.name, f.scenario.section, f.verdict.value, _last(f)) for f in findings]
    widths = [max(len(row[column]) for row in (heads, *rows)) for column in range(3)]
    lines = [_row(heads, widths), _row(tuple("-" * width for width in (*widths, 8)), widths)]
    lines += [_row(row, widths) for row in rows]
    return "\n".join([*lines, "", count(findings)])


def count(findings: Iterable[Finding]) -> str:
    """Return how many scenarios ended how."""
    found = Counter(finding.verdict for finding in findings)
    return ", ".join(f"{found[verdict]} {verdict.value}" for verdict in Verdict)


def as_json(findings: Sequence[Finding]) -> str:
    """Return the findings as JSON."""
    rows = [
        {
            "scenario": finding.scenario.name,
            "section": finding.scenario.section,
            "required": finding.scenario.required,
            "verdict": finding.verdict.value,
            "reason": finding.reason,
            "wall_s": round(finding.wall_s, 3),
        }
        for finding in findings
    ]
    return json.dumps(rows, indent=2)


def _last(finding: Finding) -> str:
    reason = f" | {finding.reason}" if finding.reason else ""
    return f"{finding.scenario.required}{reason}"


def _row(cells: Sequence[str], widths: Sequence[int]) -> str:
    padded = [f"{cell:{width}}" for cell, width in zip(cells, widths, strict=False)]
    return "  ".join([*padded, cells[-1]]).rstrip()
