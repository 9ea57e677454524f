"""Which stage of a command runs: a bar for a person at a terminal, lines for a program."""

from __future__ import annotations

import itertools
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

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
