"""The command flexbe_doctor."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Collection, Sequence
from pathlib import Path

from flexbe_testing.core.app.behavior import Known
from flexbe_testing.core.doctor.examine import Engine, count, examine
from flexbe_testing.core.doctor.finding import Finding, Report, Severity, sorted_findings
from flexbe_testing.core.doctor.module import Kind, Module
from flexbe_testing.edge.app_packages import flexbe_packages, read_packages
from flexbe_testing.edge.doctor.child import construct
from flexbe_testing.edge.doctor.surface import attributes, names_of
from flexbe_testing.edge.doctor.workspace import Package, packages

HEALTHY, SICK, USAGE = 0, 1, 2

_EPILOG = """\
Two examinations: the source text of every state and behavior, and, in a process of its own, their
import and construction, with stand-ins for messages that are not on this computer. No ROS master is
needed, and nothing of it joins ROS. Construction runs the user's code; --static leaves it out.

examples:
  rosrun flexbe_testing flexbe_doctor ~/my_workspace
  rosrun flexbe_testing flexbe_doctor ~/my_workspace/src/my_states --json

errors do not work on this engine, warnings work differently, notes could work better. The rules are
explained in docs/flexbe-doctor.md.
exit codes: 0 no errors or warnings, 1 some, 2 usage error
"""


def diagnose(workspace: Path, is_static: bool = False, limit_s: float = 20.0) -> Report:
    """Examine all states and behaviors of a workspace.

    Args:
        workspace: a folder with packages, or of one package.
        is_static: import and construct nothing.
        limit_s: how long importing and constructing one module may take [s, wall time].
    """
    found = list(packages(workspace))
    engine = Engine(names_of, attributes())
    known, findings = _known(found)
    modules: list[Module] = []
    importable: list[tuple[str, str]] = []
    for package in found:
        for file in package.files():
            new, module = _examine(file, engine, known)
            findings += new
            if module is not None:
                modules.append(module)
                importable.append((_dotted(package, file), str(file)))
    constructed = 0
    if not is_static:
        # What cannot be imported for a reason that is known already is not reported twice.
        broken = {f.file for f in findings if f.rule in ("unknown-import", "python2")}
        sound = [(name, file) for name, file in importable if file not in broken]
        new, constructed = construct(found, sound, limit_s)
        known = {(f.file, f.line) for f in findings if f.severity is Severity.ERROR}
        findings += [f for f in new if (f.file, f.line) not in known]
    return Report(
        sorted_findings(findings),
        tuple(package.name for package in found),
        sum(count(module, Kind.STATE) for module in modules),
        sum(count(module, Kind.BEHAVIOR) for module in modules),
        constructed=constructed,
    )


def _known(found: Sequence[Package]) -> tuple[Known, list[Finding]]:
    """Return what the App finds in a workspace and beside it, and what cannot be read of it."""
    states, behaviors, findings = [], [], []
    for package in found:
        try:
            known = read_packages([package.folder])
        except (OSError, ValueError) as error:
            text = f"not all of package {package.name} can be read: {error}"
            file = str(package.folder / "package.xml")
            findings.append(Finding(file, 1, "package", Severity.ERROR, text=text))
            continue
        states += known.states
        behaviors += known.behaviors
    known = _known_beside({package.name for package in found})
    return Known([*states, *known.states], [*behaviors, *known.behaviors]), findings


def _known_beside(names: Collection[str]) -> Known:
    """Return what the App finds on the ROS package path; what is wrong there is not the user's."""
    try:
        return read_packages(folder for folder in flexbe_packages() if folder.name not in names)
    except (OSError, ValueError):
        return Known()


def _examine(file: Path, engine: Engine, known: Known) -> tuple[list[Finding], Module | None]:
    try:
        text = file.read_text()
    except UnicodeDecodeError as error:
        text = f"the file is not UTF-8: {error.reason} at byte {error.start}"
        return [Finding(str(file), 1, "syntax", Severity.ERROR, text=text)], None
    return examine(str(file), text, engine, known)


def _dotted(package: Package, file: Path) -> str:
    parts = file.relative_to(package.modules).with_suffix("").parts
    return ".".join(parts).removesuffix(".__init__")


def main(words: Sequence[str]) -> int:
    """Diagnose a workspace; return the exit code."""
    parser = argparse.ArgumentParser(
        prog="flexbe_doctor",
        description="Report what of a user's states and behaviors would differ on this engine.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("workspace", metavar="WORKSPACE", help="workspace, or folder of packages")
    parser.add_argument("--json", action="store_true", help="print the report as JSON")
    parser.add_argument("--static", action="store_true", help="do not import or construct anything")
    options = parser.parse_args(words)
    workspace = Path(options.workspace).expanduser().resolve()
    if not workspace.is_dir():
        return _complain(f"{options.workspace!r} is not a folder; give a workspace or a package")
    report = diagnose(workspace, options.static)
    if not report.packages:
        return _complain(
            f"no package below {workspace} exports flexbe_states or flexbe_behaviors; add "
            "<export><flexbe_states/></export> to its package.xml"
        )
    text = (
        json.dumps(report.as_dict(), indent=2) if options.json else report.as_text(str(workspace))
    )
    sys.stdout.write(f"{text}\n")
    return SICK if any(finding.is_bad for finding in report.findings) else HEALTHY


def _complain(text: str) -> int:
    sys.stderr.write(f"flexbe_doctor: {text}\n")
    return USAGE
