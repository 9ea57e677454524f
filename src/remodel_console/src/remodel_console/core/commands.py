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
        "put the chart in the file CHART, started at START (start: where it starts itself), into "
        "the behavior as the container NAME",
    )
    SAVE = ("save", r"save", "check the behavior, and write it and its chart if it is right")
    EDIT = ("edit [PATH]", r"edit(?: (?P<path>/.*))?", "go into that container; without path: out")
    SHOW = ("show", r"show", "show the chart that is edited")
    CHECK = ("check", r"check", "tell all that is wrong with the behavior, and write nothing")
    NOTE = ("note TEXT", r"note(?: (?P<text>.+))?", "add the text to the behavior's description")
    AUTOCONNECT = ("autoconnect", r"autoconnect", "lead open outcomes to outcomes of their name")
    AUTOLAYOUT = ("autolayout", r"autolayout", "nothing: save lays every behavior out anew")
    UPDATE = ("update NAME", r"update (?P<name>.+)", "nothing but a look: files are read anew")
    FIND = (
        "findStateUsage PACKAGE.CLASS",
        r"findStateUsage[ (]['\"]?(?P<state>[\w.]+)['\"]?\)?",
        "list the charts that use a state class",
    )
    ATTACH = ("attach [LEVEL]", r"attach(?: (?P<level>-?\d+))?", "watch the behavior that runs")
    LOCK = ("lock [N]", r"lock(?: (?P<level>-?\d+))?", "hold the N-th level of the active state")
    UNLOCK = ("unlock", r"unlock", "let go what is held")
    STATEMACHINE = (
        "statemachine [NAME]",
        r"statemachine(?:[ (]['\"]?(?P<name>\w*)['\"]?\)?)?",
        "needs a selection on a canvas: refused here",
    )
    SWITCH = ("switch", r"switch|goforit", "go on in the version that was saved meanwhile")

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
    hint = f"it is written: {usages[0]}" if usages else "'help' lists the commands"
    raise CommandError(f"'{text}' is no command; {hint}")


def help_lines() -> str:
    """Return the list of all commands."""
    width = max(len(verb.usage) for verb in Verb)
    return "\n".join(f"{verb.usage:{width}}  {verb.help_text}" for verb in Verb)
