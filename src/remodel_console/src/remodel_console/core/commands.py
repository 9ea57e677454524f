"""The commands of `/flexbe/uicommand`: their spelling, which is the FlexBE App's, and their help.

A command is matched against its whole text, with no blanks around it, and with the case given.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum

from remodel_console.errors import CommandError


class Verb(Enum):
    """What a command does: its usage, its pattern, and its help."""

    HELP = ("help", r"cmd|commands|help", "list the commands")
    LOAD = ("load NAME", r"load (?P<name>.+)", "edit the behavior of that name")
    SYNTHESIZE = (
        "synthesize NAME i: START g: CHART",
        r"synthesize (?P<name>\w+) i: ?(?P<initial>.+?) g: ?(?P<goal>.+)",
        "add the chart in the file CHART, started at START (start: its own initial state), to the "
        "behavior as the container NAME",
    )
    SAVE = ("save", r"save", "check the behavior; without errors, write it and its chart")
    EDIT = (
        "edit [PATH]",
        r"edit(?: (?P<path>/.*))?",
        "open that container; without PATH, the behavior",
    )
    SHOW = ("show", r"show", "print the chart that is edited")
    CHECK = ("check", r"check", "list all errors of the behavior, and write nothing")
    NOTE = ("note TEXT", r"note(?: (?P<text>.+))?", "add the text to the behavior's description")
    AUTOCONNECT = (
        "autoconnect",
        r"autoconnect",
        "connect unconnected outcomes to those of their name",
    )
    AUTOLAYOUT = ("autolayout", r"autolayout", "no effect: save lays out every behavior")
    UPDATE = ("update NAME", r"update (?P<name>.+)", "no effect: every check reads the files again")
    FIND = (
        "findStateUsage PACKAGE.CLASS",
        r"findStateUsage[ (]['\"]?(?P<state>[\w.]+)['\"]?\)?",
        "list the charts that use a state class",
    )
    ATTACH = ("attach [LEVEL]", r"attach(?: (?P<level>-?\d+))?", "supervise the running behavior")
    LOCK = ("lock [N]", r"lock(?: (?P<level>-?\d+))?", "lock the N-th level of the active state")
    UNLOCK = ("unlock", r"unlock", "release the lock")
    STATEMACHINE = (
        "statemachine [NAME]",
        r"statemachine(?:[ (]['\"]?(?P<name>\w*)['\"]?\)?)?",
        "needs a selection on a canvas: refused here",
    )
    SWITCH = ("switch", r"switch|goforit", "continue in the version saved since the start")

    def __init__(self, usage: str, pattern: str, help_text: str) -> None:
        """Name the parts of the value."""
        self.usage = usage
        self.pattern = re.compile(pattern)
        self.help_text = help_text


@dataclass(frozen=True)
class Command:
    """A command that was understood: its verb, and what was given with it."""

    text: str
    verb: Verb
    given: Mapping[str, str] = field(default_factory=dict)


def read_command(text: str) -> Command:
    """Return the command that a text is.

    Raises:
        CommandError: if it is none.
    """
    for verb in Verb:
        found = verb.pattern.fullmatch(text)
        if found:
            return Command(text, verb, {k: v for k, v in found.groupdict().items() if v})
    word = text.split(" ", 1)[0]
    usages = [verb.usage for verb in Verb if verb.usage.split(" ")[0] == word]
    hint = f"usage: {usages[0]}" if usages else "'help' lists the commands"
    raise CommandError(f"'{text}' is no command; {hint}")


def help_lines() -> str:
    """Return the list of all commands."""
    width = max(len(verb.usage) for verb in Verb)
    return "\n".join(f"{verb.usage:{width}}  {verb.help_text}" for verb in Verb)
