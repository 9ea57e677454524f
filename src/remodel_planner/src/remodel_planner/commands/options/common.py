"""What all commands share: their entry, common options, stages and signals."""

from __future__ import annotations

import argparse
import itertools
import math
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from types import FrameType
from typing import NoReturn

from remodel_production.errors import PlannerError

Main = Callable[[list[str] | None], int]

# What a shell reports of a process that SIGPIPE has ended.
_CLOSED_PIPE = 128 + 13
_REFUSED = 1


def run(main: Callable[[], int]) -> NoReturn:
    """Run a command, and exit with its code; quietly if the reader of its output has closed it."""
    try:
        try:
            code = main()
        finally:
            sys.stdout.flush()
    except BrokenPipeError:
        # Python flushes once more at exit, into nothing.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = _CLOSED_PIPE
    sys.exit(code)


def refuses(name: str) -> Callable[[Main], Main]:
    """Let a command print an error of the planner as a line, and return 1 then, as all commands."""

    def decorate(main: Main) -> Main:
        @wraps(main)
        def guarded(arguments: list[str] | None = None) -> int:
            try:
                return main(arguments)
            except PlannerError as error:
                print(f"{name}: {error}", file=sys.stderr)
                return _REFUSED

        return guarded

    return decorate


def add_database_option(parser: argparse.ArgumentParser) -> None:
    """Add --database, by default REMODEL_DATABASE of the environment, else a local file."""
    parser.add_argument(
        "--database",
        metavar="URL",
        default=os.environ.get("REMODEL_DATABASE", "sqlite:///remodel_production.sqlite"),
        help="SQLAlchemy URL of the production database (default: %(default)s)",
    )


def seconds(text: str) -> float:
    """Read a limit of time."""
    value = float(text)
    if not math.isfinite(value) or value < 0:
        raise argparse.ArgumentTypeError(f"expected seconds of at least 0, found {text}")
    return value


def seed(text: str) -> int:
    """Read a seed."""
    value = int(text)
    if not 0 <= value < 2**31:
        raise argparse.ArgumentTypeError(f"expected an integer from 0 to 2^31 - 1, found {text}")
    return value


def seeds(text: str) -> tuple[int, ...]:
    """Read seeds, such as 0-99 or 3,7-9."""
    found: list[int] = []
    for part in text.split(","):
        first, dash, last = part.partition("-")
        try:
            found += range(seed(first), seed(last if dash else first) + 1)
        except ValueError:
            found = []
        if not found:
            raise argparse.ArgumentTypeError(f"expected seeds such as 0-99 or 3,7-9, found {text}")
    return tuple(dict.fromkeys(found))


def count(text: str) -> int:
    """Read a number of things."""
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"expected a number of at least 1, found {text}")
    return value


# [s] Wall time that a command may take without a bar.
_QUIET_S = 1.0


@contextmanager
def stages(count: int, *, is_json: bool) -> Iterator[Callable[[str], None]]:
    """Yield what begins a stage, by what it does; nothing is shown where errors go to a file.

    Args:
        count: of all stages.
        is_json: a program reads what the command prints, and gets a line on the standard error for
            each stage: `stage 2/4: laying out the board`.
    """
    if is_json:
        numbers = itertools.count(1)
        yield lambda does: print(
            f"stage {next(numbers)}/{count}: {does}", file=sys.stderr, flush=True
        )
        return
    if not sys.stderr.isatty():
        yield lambda _: None
        return
    from tqdm import tqdm  # it takes longer to load than most problems to plan

    with tqdm(
        total=count,
        file=sys.stderr,
        leave=False,
        delay=_QUIET_S,
        bar_format="{percentage:3.0f} % |{bar:16}| {elapsed}  {desc}",
    ) as bar:
        begun = 0

        def begin(does: str) -> None:
            nonlocal begun
            bar.set_description_str(does, refresh=False)
            bar.update(min(begun, 1))
            bar.refresh()
            begun += 1

        yield begin


@contextmanager
def stop_on_signals() -> Iterator[Callable[[], bool]]:
    """Give a function that returns whether SIGINT or SIGTERM has been received."""
    stopped = threading.Event()

    def stop(_signal: int, _frame: FrameType | None) -> None:
        stopped.set()

    previous = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield stopped.is_set
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)
