"""What the synthesis server does for one request, free of ROS."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.model import Chart
from flexbe_synthesizer.core.chart.problem import errors_in
from flexbe_synthesizer.core.check.check import CheckedChart
from flexbe_synthesizer.core.compile import compile_chart
from flexbe_synthesizer.core.export.instantiate import (
    WRITER,
    Instantiation,
    instantiate,
    presets,
    with_presets_written,
)
from flexbe_synthesizer.core.export.layout import lay_out
from flexbe_synthesizer.core.library.signature import Library, StateClass
from flexbe_synthesizer.edge.chart_files import ChartMemory, confined_to, find_chart
from flexbe_synthesizer.edge.output_package import expect_found, package_for
from flexbe_synthesizer.edge.package_path import read_inventory
from flexbe_synthesizer.errors import ChartFileError, ChartRefusedError, OutputError
from flexbe_synthesizer.synthesis import CheckedFiles, check_files, started_at, write_behaviors

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
