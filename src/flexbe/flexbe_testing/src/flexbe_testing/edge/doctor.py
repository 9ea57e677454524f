"""The command flexbe_doctor, and what the FlexBE App knows of ROS packages."""

from __future__ import annotations

import argparse
import ast
import contextlib
import importlib.util
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

from flexbe_core.behavior_library import XML_ERRORS, packages_exporting
from flexbe_testing.core.app_behavior import (
    AppLoadError,
    BehaviorDefinition,
    Known,
    StateDefinition,
    read_state,
)
from flexbe_testing.core.app_load import define_behavior
from flexbe_testing.core.doctor_module import (
    Finding,
    Kind,
    Module,
    Report,
    Severity,
    sorted_findings,
)
from flexbe_testing.core.doctor_rules import Engine, count, examine

_EXPORTS = ("flexbe_states", "flexbe_behaviors")


def read_packages(folders: Iterable[Path]) -> Known:
    """Return what the App finds in the folders of packages that export states or behaviors.

    Raises:
        ValueError: if a package.xml or manifest is not XML, or a module not UTF-8.
    """
    states: list[StateDefinition] = []
    behaviors: list[BehaviorDefinition] = []
    for folder in folders:
        package = _parse(folder / "package.xml")
        modules = folder / "src" / (package.findtext("name") or "").strip()
        if package.find("export/flexbe_states") is not None:
            states += _read_states(modules)
        if package.find("export/flexbe_behaviors") is not None:
            behaviors += _read_behaviors(folder, modules)
    return Known(states, behaviors)


def _read_states(modules: Path) -> Iterator[StateDefinition]:
    """Yield the state of each file in the module folder of a package."""
    for file in sorted(modules.rglob("*.py")):
        if file.name != "__init__.py":
            module = ".".join(file.relative_to(modules.parent).with_suffix("").parts)
            found = read_state(_read_source(file), module)
            if found is not None:
                yield found


def _read_behaviors(folder: Path, modules: Path) -> Iterator[BehaviorDefinition]:
    """Yield the behaviors of a package; those that the App cannot load are left out."""
    for file in sorted((folder / "manifest").glob("*.xml")):
        executable = _parse(file).find("executable")
        path = "" if executable is None else executable.get("package_path", "")
        code = modules / f"{path.partition('.')[2]}.py"
        if path.count(".") == 1 and code.is_file():
            with contextlib.suppress(AppLoadError):
                yield define_behavior(_read_source(code), f"{modules.name}.{code.stem}")


def _read_source(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise ValueError(f"{file} is not UTF-8: {error.reason} at byte {error.start}") from error


def _parse(file: Path) -> ElementTree.Element:
    try:
        return ElementTree.parse(file).getroot()
    except XML_ERRORS as error:
        raise ValueError(f"{file} is not XML: {error}") from error


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
    beside: dict[str, Path] = {}
    for element in _EXPORTS:
        beside |= packages_exporting(element, lambda text: None)
    own = {package.name: package.folder for package in found}
    for name, folder in {**own, **beside, **own}.items():  # the workspace's own first
        try:
            known = read_packages([folder])
        except (OSError, ValueError) as error:
            if name in own:  # what is wrong beside the workspace is not the user's
                text = f"not all of package {name} can be read: {error}"
                file = str(folder / "package.xml")
                findings.append(Finding(file, 1, "package", Severity.ERROR, text=text))
            continue
        states += known.states
        behaviors += known.behaviors
    return Known(states, behaviors), findings


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


# Run the construction of a user's classes in a process of its own


# Nothing listens there: whatever asks for a ROS master is refused at once.
_NO_MASTER = "http://127.0.0.1:9"

# [s] Wall time that the child gets for its own imports, and between two inspections of it.
_START_LIMIT_S = 60.0
_POLL_S = 0.05

Modules = Sequence[tuple[str, str]]


def construct(
    packages: Sequence[Package], modules: Modules, limit_s: float
) -> tuple[list[Finding], int]:
    """Import modules, and construct their states and behaviors.

    Args:
        packages: the packages whose modules may be imported.
        modules: dotted names and files, of files that are Python 3.
        limit_s: how long one module may take [s, wall time]; one that takes longer is a finding.

    Returns:
        findings, and how many classes were constructed.
    """
    findings: list[Finding] = []
    constructed, rest = 0, list(modules)
    while rest:
        with tempfile.TemporaryDirectory() as folder:
            result, ended = _run(packages, rest, limit_s, Path(folder))
        findings += [_finding(row) for row in result["findings"]]
        constructed += result["constructed"]
        if not result["at"]:
            break
        # User code ended the process: report the module, and continue after it in another process.
        index = [name for name, _ in rest].index(result["at"])
        file = rest[index][1]
        text = f"importing or constructing it {ended}; keep such code out of module and constructor"
        findings.append(Finding(file, 1, "construction", Severity.ERROR, text=text))
        rest = rest[index + 1 :]
    return findings, constructed


def _run(
    packages: Sequence[Package], modules: Modules, limit_s: float, folder: Path
) -> tuple[dict, str]:
    request, result = folder / "request.json", folder / "result.json"
    folders = [str(package.modules) for package in packages]
    request.write_text(json.dumps({"folders": folders, "modules": list(modules)}))
    command = [sys.executable, "-m", "flexbe_testing.ros.doctor_child", request, result]
    environment = {**os.environ, "ROS_MASTER_URI": _NO_MASTER, "ROS_LOG_DIR": str(folder)}
    with (folder / "errors").open("w+") as errors:
        child = subprocess.Popen(
            command,
            cwd=folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=errors,
            start_new_session=True,
        )
        try:
            ended = _watch(child, result, limit_s)
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(child.pid, signal.SIGKILL)  # with all that user code has started
            child.wait()
        if not result.exists():
            errors.seek(0)
            raise RuntimeError(f"the doctor's own process failed: {errors.read().strip()[-500:]}")
    return json.loads(result.read_text()), ended


def _watch(child: subprocess.Popen[bytes], result: Path, limit_s: float) -> str:
    """Wait until the child ends or does not get on; return which, for a sentence."""
    seen, end = "", time.monotonic() + _START_LIMIT_S
    while time.monotonic() < end:
        with contextlib.suppress(subprocess.TimeoutExpired):
            return f"ended the process with {child.wait(_POLL_S)}"
        now = result.read_text() if result.exists() else ""
        if now != seen:
            seen, end = now, time.monotonic() + limit_s
    return f"took more than {limit_s:g} s"


def _finding(row: dict) -> Finding:
    severity = Severity(row["severity"])
    return Finding(row["file"], row["line"], row["rule"], severity, text=row["text"])


# What flexbe_core of this engine has, read from its source


@cache
def names_of(module: str) -> frozenset[str] | None:
    """Return the names that a module of flexbe_core binds; None if there is no such module."""
    file = _file(module)
    if file is None:
        return None
    names: set[str] = set()
    for node in ast.parse(file.read_text()).body:
        names |= _bound(node)
    return frozenset(names)


@cache
def attributes() -> frozenset[str]:
    """Return the names that states and containers of this engine have, methods included."""
    names: set[str] = set()
    for file in (_root() / "core").glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.ClassDef):
                for item in node.body:
                    names |= _bound(item)
            elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
                names.add(node.attr)
    return frozenset(names)


@cache
def _root() -> Path:
    spec = importlib.util.find_spec("flexbe_core")
    if spec is None or spec.origin is None:
        raise ImportError("flexbe_core is not on PYTHONPATH; source the workspace's setup.sh")
    return _source(Path(spec.origin)).parent


def _source(file: Path) -> Path:
    """Return the file that a stub in catkin's devel space stands for; the file itself if none."""
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Constant) and str(node.value).startswith("/"):
            source = Path(str(node.value)) / "flexbe_core" / "__init__.py"
            if source.is_file():
                return source
    return file


def _file(module: str) -> Path | None:
    path = _root().joinpath(*module.split(".")[1:])
    for file in (path / "__init__.py", path.with_suffix(".py")):
        if file.is_file():
            return file
    return None


def _bound(node: ast.stmt) -> set[str]:
    if isinstance(node, ast.Import | ast.ImportFrom):
        return {alias.asname or alias.name.split(".")[0] for alias in node.names}
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        return {node.name}
    targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
    return {target.id for target in targets if isinstance(target, ast.Name)}


# The FlexBE packages of a workspace


_SKIPPED = {"build", "devel", "install", "logs"}


@dataclass(frozen=True)
class Package:
    """A package that exports states or behaviors.

    Attributes:
        name: its name.
        folder: its folder.
        modules: the folder with its Python package, to be put on the path.
    """

    name: str
    folder: Path
    modules: Path

    def files(self) -> list[Path]:
        """Return its Python files."""
        return sorted((self.modules / self.name).rglob("*.py"))


def packages(workspace: Path) -> Iterator[Package]:
    """Yield the FlexBE packages below a folder, as catkin finds packages."""
    for folder, subfolders, files in os.walk(workspace):
        if "CATKIN_IGNORE" in files:
            subfolders.clear()
            continue
        if "package.xml" in files:
            subfolders.clear()
            if (name := _exporting(Path(folder) / "package.xml")) is not None:
                yield _package(name, Path(folder))
            continue
        subfolders[:] = sorted(
            name for name in subfolders if name not in _SKIPPED and not name.startswith(".")
        )


def _package(name: str, folder: Path) -> Package:
    modules = folder / "src" if (folder / "src" / name).is_dir() else folder
    return Package(name, folder, modules)


def _exporting(file: Path) -> str | None:
    """Return the name of a package that exports states or behaviors.

    A package whose package.xml is not XML gets the name of its folder, so that it is examined too.
    """
    try:
        root = ElementTree.parse(file).getroot()
    except XML_ERRORS:
        text = file.read_text(errors="replace")
        return file.parent.name if any(element in text for element in _EXPORTS) else None
    if all(root.find(f"export/{element}") is None for element in _EXPORTS):
        return None
    return (root.findtext("name") or "").strip() or None
