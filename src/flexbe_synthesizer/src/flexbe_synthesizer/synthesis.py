"""The whole way from charts to behaviors, for the command line and for requests to the server."""

from __future__ import annotations

import ast
import gc
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from enum import IntEnum
from functools import partial
from hashlib import sha256
from pathlib import Path
from types import MappingProxyType

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.chart_reader import read_chart
from flexbe_synthesizer.core.chart.model import Chart
from flexbe_synthesizer.core.chart.problem import ChartError, Problem, ProblemKind, errors_in
from flexbe_synthesizer.core.check.check import CheckedChart, check_chart
from flexbe_synthesizer.core.compile import Unit, check_units, compile_chart, manifest_of
from flexbe_synthesizer.core.export.certificate import certify, write_certificate
from flexbe_synthesizer.core.export.layout import (
    WRITER,
    Instantiation,
    instantiate,
    lay_out,
    presets,
    with_presets_written,
)
from flexbe_synthesizer.core.export.render_python import render_python
from flexbe_synthesizer.core.library.signature import Library, StateClass
from flexbe_synthesizer.core.library.sources import write_manifest
from flexbe_synthesizer.core.machine.machine import Machine
from flexbe_synthesizer.core.machine.machine_reader import ManualSectionError, read_manual_sections
from flexbe_synthesizer.edge.chart_files import ChartMemory, confined_to, find_chart, read_charts
from flexbe_synthesizer.edge.files import read_regular, write_all
from flexbe_synthesizer.edge.output_package import (
    OutputPackage,
    chart_place,
    expect_found,
    expect_own,
    package_for,
)
from flexbe_synthesizer.edge.package_path import read_inventory
from flexbe_synthesizer.errors import ChartFileError, ChartRefusedError, OutputError


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


START = "start"  # what D5.1's command line writes for "where the chart itself starts"


class ErrorCode(IntEnum):
    """Values of `SynthesisErrorCodes` that this server sends."""

    SUCCESS = 1
    CHART_NOT_FOUND = 101
    CHART_REFUSED = 102
    CHART_INVALID = 103
    OUTCOMES_DIFFER = 104
    INITIAL_UNKNOWN = 105
    OUTPUT_FAILED = 106
    CANCELLED = 107
    QUEUE_FULL = 108
    INTERNAL = 109
    OUT_OF_TIME = 110


class RequestError(Exception):
    """A request cannot be fulfilled: the code to send, and the text for people."""

    def __init__(self, code: ErrorCode, text: str) -> None:
        """Keep the code; the text is the message."""
        self.code = code
        super().__init__(text)


@dataclass(frozen=True)
class Settings:
    """The folders in which the server finds charts, states and behaviors, and where it writes.

    Attributes:
        output: package for the behaviors of charts that lie in no package.
    """

    chart_folders: tuple[Path, ...]
    output: Path
    ros_package_path: str


@dataclass(frozen=True)
class Request:
    """What a client asks for; field by field as in `flexbe_msgs/SynthesisRequest`."""

    goal: str
    initial_condition: str = ""
    sm_outcomes: tuple[str, ...] = ()


@dataclass(frozen=True)
class RequestResult:
    """What a request gives: the states, root first; the files that changed; warnings."""

    states: tuple[Instantiation, ...]
    written: tuple[Path, ...]
    warnings: tuple[str, ...]


Report = Callable[[str, float], None]
ExpectTime = Callable[[], None]


def deadline(limit_s: float, now: Callable[[], float]) -> ExpectTime:
    """Return a function that ends the request that calls it once its time is over.

    Args:
        limit_s: how long it may take from now on [s].
        now: returns the time [s].
    """
    end = now() + limit_s

    def expect_time() -> None:
        if now() > end:
            text = f"the synthesis took more than {limit_s:g} s and was ended; nothing was written"
            raise RequestError(ErrorCode.OUT_OF_TIME, text)

    return expect_time


def fulfil(
    request: Request,
    settings: Settings,
    report: Report,
    expect_time: ExpectTime = lambda: None,
    memory: ChartMemory | None = None,
) -> RequestResult:
    """Synthesize the chart that a request names: write its behavior, return its states.

    Args:
        request: what is asked for.
        settings: where things are.
        report: called with each step and the progress [0, 1].
        expect_time: called before each step, and again and again while a chart is read and
            checked. What either raises ends the request.
        memory: has the charts of earlier requests.

    Raises:
        RequestError: if the request cannot be fulfilled; then nothing was written.
    """
    try:

        def report_in_time(status: str, progress: float) -> None:
            expect_time()
            report(status, progress)

        return _fulfil(request, settings, report_in_time, expect_time, memory=memory)
    except ChartRefusedError as error:
        raise RequestError(ErrorCode.CHART_REFUSED, str(error)) from error
    except ChartFileError as error:
        raise RequestError(ErrorCode.CHART_NOT_FOUND, str(error)) from error
    except OutputError as error:
        raise RequestError(ErrorCode.OUTPUT_FAILED, str(error)) from error


def _fulfil(
    request: Request,
    settings: Settings,
    report: Report,
    expect_time: ExpectTime,
    memory: ChartMemory | None,
) -> RequestResult:
    report(f"looking for the chart '{request.goal}'", 0.0)
    path = find_chart(request.goal, settings.chart_folders)
    report("reading the states and behaviors on the ROS package path", 0.1)
    inventory = read_inventory(settings.ros_package_path)
    library = inventory.library
    locate = confined_to(settings.chart_folders)
    files = check_files(
        [path],
        library,
        lambda chart: package_for(Path(chart), settings.output),
        locate,
        report=lambda chart: report(f"checking {chart}", 0.4),
        expect_time=expect_time,
        memory=memory,
    )
    errors = errors_in(files.problems)
    if errors:
        raise RequestError(ErrorCode.CHART_INVALID, "\n".join(map(str, errors)))
    file, checked = next(iter(files.charts.items()))
    package = files.packages[file]
    _expect_outcomes(request, checked.resolved.chart)
    for other, one in files.charts.items():
        expect_found(one.resolved.chart.name, files.packages[other], inventory)
    report("making the states", 0.6)
    states = _states(_started(request, checked, files, library), package.name, library)
    report(f"writing to the package {package.name}", 0.8)
    written = write_behaviors(files)
    warnings = (*inventory.warnings, *map(str, files.problems))
    return RequestResult(states, written, warnings)


def _expect_outcomes(request: Request, chart: Chart) -> None:
    """Refuse a request for other outcomes than the chart has."""
    own = tuple(outcome.name for outcome in chart.outcomes)
    if request.sm_outcomes and set(request.sm_outcomes) != set(own):
        text = f"the request asks for the outcomes {names.quoted(request.sm_outcomes)}; the chart "
        text += f"'{chart.name}' has {names.quoted(own)}. Ask for these, or rename them there."
        raise RequestError(ErrorCode.OUTCOMES_DIFFER, text)


def _started(
    request: Request, checked: CheckedChart, files: CheckedFiles, library: Library
) -> CheckedChart:
    """Return the chart, started where the request says."""
    initial = request.initial_condition.strip()
    if initial in ("", START, checked.resolved.chart.initial):
        return checked
    if initial not in checked.resolved.by_id:
        hint = names.allowed(initial, (START, *checked.resolved.by_id))
        text = f"the initial condition '{initial}' is no state of the chart; {hint}"
        raise RequestError(ErrorCode.INITIAL_UNKNOWN, text)
    restarted = started_at(files, library, initial)
    errors = errors_in(restarted.problems)
    if errors:
        text = f"started at '{initial}', the chart has errors:\n" + "\n".join(map(str, errors))
        raise RequestError(ErrorCode.CHART_INVALID, text)
    return restarted


def _states(checked: CheckedChart, package: str, library: Library) -> tuple[Instantiation, ...]:
    """Return the states of a chart as the FlexBE App takes them."""
    root = compile_chart(checked, package).root
    if presets(root):
        found = library.find_states("/".join(WRITER))
        writer = found[0] if found else None
        if not isinstance(writer, StateClass):
            text = f"attempts need the state class {WRITER[1]} of package {WRITER[0]} in the "
            text += "FlexBE App, and it is not on the ROS package path"
            raise RequestError(ErrorCode.CHART_INVALID, text)
        root = with_presets_written(root, writer)
    return instantiate(root, lay_out(root))
