"""The whole way from chart files to behavior files, as the command line and the server go it."""

from __future__ import annotations

import ast
import gc
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from hashlib import sha256
from pathlib import Path
from types import MappingProxyType

from flexbe_synthesizer.core.chart.chart_reader import read_chart
from flexbe_synthesizer.core.chart.problem import ChartError, Problem, ProblemKind, errors_in
from flexbe_synthesizer.core.check.check import CheckedChart, check_chart
from flexbe_synthesizer.core.compile import Unit, check_units, compile_chart, manifest_of
from flexbe_synthesizer.core.export.certificate import certify, write_certificate
from flexbe_synthesizer.core.export.layout import lay_out
from flexbe_synthesizer.core.export.render_python import render_python
from flexbe_synthesizer.core.library.manifest import write_manifest
from flexbe_synthesizer.core.library.signature import Library
from flexbe_synthesizer.core.machine.machine import Machine
from flexbe_synthesizer.core.machine.machine_reader import ManualSectionError, read_manual_sections
from flexbe_synthesizer.edge.chart_files import ChartMemory, read_charts
from flexbe_synthesizer.edge.files import read_regular, write_all
from flexbe_synthesizer.edge.output_package import OutputPackage, chart_place, expect_own
from flexbe_synthesizer.errors import OutputError


@dataclass(frozen=True)
class CheckedFiles:
    """Charts that were read and checked together.

    Attributes:
        charts: by path, those asked for first, then those that they name.
        packages: where the behavior of each chart goes, by path.
        problems: everything wrong, in the order of files and lines.
    """

    charts: Mapping[str, CheckedChart]
    packages: Mapping[str, OutputPackage]
    problems: tuple[Problem, ...]


@contextmanager
def garbage_kept() -> Iterator[None]:
    """Defer the collection of garbage cycles: a chart's parts live to the end of a synthesis.

    The collector would look through all of them again and again, and find nothing; with ten
    thousand states that is half the time.
    """
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_enabled:
            gc.enable()


@garbage_kept()
def check_files(
    paths: Sequence[str],
    library: Library,
    package_of: Callable[[str], OutputPackage],
    locate: Callable[[str], Path] = Path,
    drafts: Mapping[str, bytes] = MappingProxyType({}),
    report: Callable[[str], None] = lambda _path: None,
    expect_time: Callable[[], None] = lambda: None,
    memory: ChartMemory | None = None,
) -> CheckedFiles:
    """Read the charts, and those that they name, and check all.

    Args:
        paths: files of the charts.
        library: what is on the ROS package path.
        package_of: returns the package that the behavior of a chart goes to.
        locate: returns the file to read for a path, or refuses it.
        drafts: contents that stand for those of the files, by path.
        report: called with the path of each chart before it is checked.
        expect_time: called again and again; what it raises ends the check.
        memory: has what was read and checked before.

    Raises:
        SynthesisError: if a file cannot be read, or belongs to no package.
    """
    read = partial(memory.read if memory else read_chart, expect_time=expect_time)
    files = read_charts(paths, locate, drafts, read)
    packages = {chart.file: package_of(chart.file) for chart in files.charts}
    units = [Unit(chart, packages[chart.file].name) for chart in files.charts]
    check = partial(memory.check if memory else check_chart, expect_time=expect_time)
    checked = check_units(units, library, report, check)
    problems = list(files.problems)
    known = {(problem.position, problem.code) for problem in problems}
    for one in checked.values():
        problems += (p for p in one.problems if (p.position, p.code) not in known)
    order = {path: index for index, path in enumerate(checked)}
    problems.sort(key=lambda p: (order.get(p.position.file, -1), *p.position[1:]))
    return CheckedFiles(checked, packages, tuple(dict.fromkeys(problems)))


def started_at(files: CheckedFiles, library: Library, initial: str) -> CheckedChart:
    """Return the first chart as if another of its states were the initial one.

    States that only the path before it leads to are then no mistake.
    """
    checked = list(files.charts.values())
    first = checked[0].resolved.chart
    charts = [replace(first, initial=initial), *(one.resolved.chart for one in checked[1:])]
    units = [Unit(chart, files.packages[chart.file].name) for chart in charts]
    restarted = check_units(units, library)[first.file]
    problems = tuple(p for p in restarted.problems if p.code is not ProblemKind.UNREACHABLE_STATE)
    return replace(restarted, problems=problems)


@garbage_kept()
def write_behaviors(
    files: CheckedFiles, beside: Mapping[Path, str] = MappingProxyType({})
) -> tuple[Path, ...]:
    """Write the behavior, manifest and certificate of each chart; return what changed.

    Args:
        files: the charts.
        beside: texts of files to write together with them.

    Raises:
        ChartError: if a chart has errors.
        OutputError: if a file cannot be written, or belongs to another chart; then none is.
    """
    errors = errors_in(files.problems)
    if errors:
        raise ChartError(errors)
    texts: dict[Path, str] = dict(beside)
    for path, checked in files.charts.items():
        package = files.packages[path]
        machine = compile_chart(checked, package.name)
        texts.update(package.missing)
        expect_own(machine.name, path, package)
        text = render_behavior(machine, package.code_path(machine.name))
        texts[package.code_path(machine.name)] = text
        manifest = write_manifest(
            manifest_of(machine), machine.description, machine.author, machine.tags
        )
        texts[package.manifest_path(machine.name)] = manifest
        manual = [name for name, code in read_manual_sections(text).items() if code.strip()]
        texts[package.certificate_path(machine.name)] = write_certificate(
            certify(checked, package.name),
            chart_place(path, package),
            sha256(text.encode()).hexdigest(),
            manual,
        )
    return write_all(texts)


def render_behavior(machine: Machine, path: Path) -> str:
    """Return the text of a behavior's file, with the manual sections of the one that is there.

    Raises:
        OutputError: if the manual sections cannot be kept.
    """
    manual: Mapping[str, str] = {}
    try:
        if path.exists():
            manual = read_manual_sections(read_regular(path).decode())
        text = render_python(machine, lay_out(machine.root), manual)
        if any(section.strip() for section in manual.values()):
            ast.parse(text)
    except ManualSectionError as error:
        raise OutputError(f"{path} cannot be written again: {error}") from error
    except SyntaxError as error:
        raise OutputError(
            f"{path} cannot be written again: its manual sections do not fit, line {error.lineno} "
            f"of the result is not Python ({error.msg}); indent them by four blanks a level"
        ) from error
    except (OSError, ValueError) as error:
        raise OutputError(f"{path} cannot be read: {error}") from error
    return text
