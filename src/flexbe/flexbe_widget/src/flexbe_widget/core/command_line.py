"""The command lines of be_launcher and of breakpoint."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass

from flexbe_core.engine.supervision import UNSUPERVISED
from flexbe_widget.core.run_watch import MEANINGS

# [s] How long to wait for an engine that is there and free.
DEFAULT_WAIT_S = 10.0

_DESCRIPTION = """\
Start a behavior on the behavior engine, print its progress, and exit when it ends.
Without -b, wait for requests on flexbe/request_behavior and pass them on to the engine.
"""

_EXAMPLES = """\
examples:
  rosrun flexbe_widget be_launcher -b 'Example Behavior'
  rosrun flexbe_widget be_launcher -b my_first_behavior --input placepin_id=7
  roslaunch flexbe_widget be_launcher.launch behavior_name:='Example Behavior'

"""


@dataclass(frozen=True)
class CommandLine:
    """The options of the command line.

    Attributes:
        behavior: display name; empty to serve requests.
        autonomy_level: level to run at.
        parameters: (key, value) pairs.
        inputs: (key, value) pairs.
        wait_s: [s] how long to wait for the engine.
        success: outcomes that are a success; none for all but 'failed' and 'preempted'.
    """

    behavior: str
    autonomy_level: int
    parameters: tuple[tuple[str, str], ...]
    inputs: tuple[tuple[str, str], ...]
    wait_s: float
    success: tuple[str, ...] = ()


def read_command_line(words: Sequence[str]) -> CommandLine:
    """Return the options that the words set; options and parameters come in any order.

    Raises:
        SystemExit: after a usage error, or after --help; the text is printed.
    """
    parser = _parser()
    options = parser.parse_intermixed_args([word for word in words if not _is_for_ros(word)])
    return CommandLine(
        behavior=options.behavior,
        autonomy_level=options.autonomy,
        parameters=tuple(_parameter(word, parser) for word in options.parameters),
        inputs=tuple(_pair(word, "=", parser) for word in options.input),
        wait_s=options.wait,
        success=tuple(options.success),
    )


def _parser() -> argparse.ArgumentParser:
    codes = "".join(f"  {code.value:<4}{text}\n" for code, text in MEANINGS.items())
    parser = argparse.ArgumentParser(
        "be_launcher",
        description=_DESCRIPTION,
        epilog=f"{_EXAMPLES}exit codes, with -b:\n{codes}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("-b", "--behavior", default="", metavar="NAME", help="behavior to start")
    parser.add_argument(
        *("-a", "--autonomy"),
        type=_level,
        default=UNSUPERVISED,
        metavar="LEVEL",
        help="0 to 3 with an operator, 255 (default) without supervision",
    )
    parser.add_argument(
        *("-i", "--input"),
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="input of the behavior, a Python literal or file://PATH; may be repeated",
    )
    parser.add_argument(
        *("-s", "--success"),
        action="append",
        default=[],
        metavar="OUTCOME",
        help="only this outcome is exit code 0, any other one is 1; may be repeated",
    )
    parser.add_argument(
        *("-w", "--wait"),
        type=_seconds,
        default=DEFAULT_WAIT_S,
        metavar="SECONDS",
        help=f"wait at most this long for a free engine (default {DEFAULT_WAIT_S:g})",
    )
    parser.add_argument(
        "parameters", nargs="*", metavar="KEY:=VALUE", help="parameter of the behavior"
    )
    return parser


def _is_for_ros(word: str) -> bool:
    """Return whether a word names the node, its log or its namespace, as roslaunch adds."""
    return word.startswith("__") and ":=" in word


def _parameter(word: str, parser: argparse.ArgumentParser) -> tuple[str, str]:
    """Return key and value; a key without a path means all behaviors that have it."""
    key, value = _pair(word, ":=", parser)
    return key if key.startswith("/") else f"/{key}", value


def _pair(word: str, separator: str, parser: argparse.ArgumentParser) -> tuple[str, str]:
    key, found, value = word.partition(separator)
    if not found or not key:
        parser.error(f"{word!r} is neither an option nor of the form key{separator}value")
    return key, value


def _level(word: str) -> int:
    level = int(word) if word.isdigit() else -1
    if not 0 <= level <= UNSUPERVISED:
        raise argparse.ArgumentTypeError(f"{word!r} is not a level from 0 to {UNSUPERVISED}")
    return level


def _seconds(word: str) -> float:
    try:
        seconds = float(word)
    except ValueError:
        seconds = -1.0
    if not 0 <= seconds < float("inf"):
        raise argparse.ArgumentTypeError(f"{word!r} is not a number of seconds")
    return seconds


# The command line of breakpoint


def read_breakpoints(words: Sequence[str]) -> list[str]:
    """Return the paths of the states that are to be breakpoints.

    Raises:
        ValueError: if a word is not a path of a state.
    """
    wrong = [word for word in words if not word.startswith("/") or word.endswith("/")]
    if wrong:
        raise ValueError(
            f"{', '.join(map(repr, wrong))}: a breakpoint is the path of a state, such as "
            "/Container/State; the behavior's name is not part of it"
        )
    return list(dict.fromkeys(words))
