"""What can be wrong with a chart, and where it is.

`ProblemKind` is the one list of all errors and warnings; a test compares docs/reference/errors.md
with it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from enum import Enum
from typing import NamedTuple


class Position(NamedTuple):
    """A place in a file; line and column count from 1, columns in characters."""

    file: str
    line: int
    column: int


class Severity(Enum):
    """Whether a problem stops the synthesis."""

    ERROR = "error"
    WARNING = "warning"


class ProblemKind(Enum):
    """Kinds of problems: the name shown, what it means, how grave it is."""

    NOT_XML = ("not-xml", "the file is not well-formed XML")
    DOCTYPE = ("doctype", "a document type or entity declaration; charts have none")
    DUPLICATE_ATTRIBUTE = ("duplicate-attribute", "an attribute stands twice in one element")
    UNBOUND_PREFIX = ("unbound-prefix", "a namespace prefix that no xmlns declares")
    UNKNOWN_ELEMENT = ("unknown-element", "an element that the language does not have")
    MISPLACED_ELEMENT = ("misplaced-element", "an element in a place where it means nothing")
    MISSING_ELEMENT = ("missing-element", "no datamodel, no outcome, or no state at all")
    NESTED_TOO_DEEPLY = ("nested-too-deeply", "more than 16 containers inside each other")
    DUPLICATE_ELEMENT = ("duplicate-element", "an element that may stand once stands twice")
    UNEXPECTED_TEXT = ("unexpected-text", "text between elements")
    UNKNOWN_ATTRIBUTE = ("unknown-attribute", "an attribute that the element does not have")
    MISSING_ATTRIBUTE = ("missing-attribute", "a required attribute is absent or empty")
    UNKNOWN_EXTENSION = (
        "unknown-extension",
        "a name that the extension does not have in this place",
    )
    INVALID_VALUE = ("invalid-value", "an attribute's value is outside what it allows")
    INVALID_NAME = ("invalid-name", "a name with characters that FlexBE cannot carry")
    RESERVED_NAME = ("reserved-name", "a name that already means something else")
    UNKNOWN_TYPE = ("unknown-type", "a data type that the language does not have")
    DUPLICATE_ID = ("duplicate-id", "two states or behaviors with one id")
    DUPLICATE_NAME = ("duplicate-name", "two outcomes, inputs, outputs or parameters of one name")
    DUPLICATE_BEHAVIOR = ("duplicate-behavior", "two charts or behaviors that become one class")
    UNKNOWN_CLASS = ("unknown-class", "no state class of that name on the ROS package path")
    AMBIGUOUS_CLASS = ("ambiguous-class", "several packages have a state class of that name")
    UNREADABLE_CLASS = ("unreadable-class", "a state class whose signature cannot be read")
    UNKNOWN_BEHAVIOR = ("unknown-behavior", "no behavior or chart of that name")
    AMBIGUOUS_BEHAVIOR = ("ambiguous-behavior", "several packages have a behavior of that name")
    UNREADABLE_BEHAVIOR = ("unreadable-behavior", "a behavior whose interface cannot be read")
    CHART_CYCLE = ("chart-cycle", "a chart that contains itself, directly or through others")
    UNKNOWN_PARAMETER = ("unknown-parameter", "a parameter that the state or behavior lacks")
    MISSING_PARAMETER = ("missing-parameter", "a parameter without default is not given")
    PARAMETER_TYPE = ("parameter-type", "a parameter's value has the wrong type")
    PARAMETER_SOURCE = ("parameter-source", "a parameter that takes Python source")
    UNKNOWN_INITIAL = ("unknown-initial", "the initial state does not exist")
    UNKNOWN_EVENT = ("unknown-event", "a transition for an outcome that the state does not have")
    MISSING_TRANSITION = ("missing-transition", "an outcome of a state that leads nowhere")
    DUPLICATE_TRANSITION = ("duplicate-transition", "two transitions for one outcome of a state")
    UNKNOWN_TARGET = ("unknown-target", "a transition to what is neither a state nor an outcome")
    UNKNOWN_ERROR_CODE = ("unknown-error-code", "no error code or class of codes of that name")
    UNREACHABLE_STATE = ("unreachable-state", "no path from the initial state leads there")
    NO_WAY_OUT = ("no-way-out", "a state from which no outcome can be reached")
    UNKNOWN_INPUT = ("unknown-input", "an input that the state or the chart does not have")
    UNKNOWN_OUTPUT = ("unknown-output", "an output that the state or the chart does not have")
    UNKNOWN_STATE = ("unknown-state", "a connection from or to a state that does not exist")
    DUPLICATE_CONNECTION = ("duplicate-connection", "two connections into one input of a state")
    CONFLICTING_OUTPUT = ("conflicting-output", "one value that would have to have two homes")
    UNBOUND_INPUT = ("unbound-input", "an input that nothing feeds")
    UNFED_OUTPUT = ("unfed-output", "an output of the chart that nothing feeds")
    ENDLESS_CONTAINER = ("endless-container", "states that end together and leave no condition met")
    READ_BEFORE_WRITE = ("read-before-write", "a path on which a value is read but not yet written")
    OVERWRITTEN_VALUE = ("overwritten-value", "a path on which another state's value is read")
    TYPE_CONFLICT = ("type-conflict", "the two ends of a data flow have different types")
    UNUSED_INPUT = ("unused-input", "an input of the chart that no state reads", Severity.WARNING)
    UNUSED_OUTPUT = (
        "unused-output",
        "an output that the chart declares at a state and nothing reads",
        Severity.WARNING,
    )
    SHADOWED_NAME = (
        "shadowed-name",
        "an input of the chart that hides another state's output of its name",
        Severity.WARNING,
    )
    UNBOUNDED_LOOP = ("unbounded-loop", "a loop without any limit of attempts", Severity.WARNING)
    UNCANCELLED_ABILITY = (
        "uncancelled-ability",
        "a state that sends a goal and never cancels it",
        Severity.WARNING,
    )
    UNUSED_OUTCOME = (
        "unused-outcome",
        "an outcome of the chart that no transition reaches",
        Severity.WARNING,
    )

    def __init__(self, slug: str, meaning: str, severity: Severity = Severity.ERROR) -> None:
        self.slug = slug
        self.meaning = meaning
        self.severity = severity


@dataclass(frozen=True)
class Problem:
    """One thing wrong at one place: what was found, what is allowed, how to mend it."""

    position: Position
    code: ProblemKind
    message: str

    def __str__(self) -> str:
        """Return the line shown to the user, `file:line:column: [code] message`."""
        file, line, column = self.position
        mark = "warning: " if self.code.severity is Severity.WARNING else ""
        return f"{file}:{line}:{column}: {mark}[{self.code.slug}] {self.message}"


MOST_ERRORS = 1000  # of a chart, after which no more are searched for


class ProblemList(list[Problem]):
    """Problems as they are found, up to `MOST_ERRORS` errors."""

    def __init__(self, expect_time: Callable[[], None] = lambda: None) -> None:
        """Begin without problems; `expect_time` is called at each, and what it raises ends it."""
        super().__init__()
        self._expect_time = expect_time
        self._errors = 0

    @property
    def is_full(self) -> bool:
        """Return whether the search for problems can end."""
        return self._errors >= MOST_ERRORS

    def take(self, problem: Problem) -> None:
        """Add a problem; the last one that there is room for says that it is the last."""
        self._expect_time()
        self._errors += problem.code.severity is Severity.ERROR
        if self.is_full:
            more = f" No more is checked after {MOST_ERRORS} errors; correct these first."
            problem = replace(problem, message=problem.message + more)
        self.append(problem)

    def take_all(self, problems: Iterable[Problem]) -> None:
        """Add problems, as far as there is room for them."""
        for problem in problems:
            if self.is_full:
                return
            self.take(problem)


def errors_in(problems: Iterable[Problem]) -> tuple[Problem, ...]:
    """Return the problems that stop the synthesis."""
    return tuple(p for p in problems if p.code.severity is Severity.ERROR)


class ChartError(ValueError):
    """A chart cannot be used; `problems` says why, all at once."""

    def __init__(self, problems: Iterable[Problem]) -> None:
        """Keep the problems; the message is their lines."""
        self.problems = tuple(problems)
        super().__init__("\n".join(map(str, self.problems)))
