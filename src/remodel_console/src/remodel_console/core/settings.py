"""What is configured and arranged on pages, kept across restarts as JSON."""

from __future__ import annotations

import json
import posixpath
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields, replace
from typing import get_type_hints

from remodel_console.core.plots import split_plot

MOST_PLOTS = 8  # more would slow the pages down
_LONGEST = 200  # letters of a text; none of them needs more


@dataclass(frozen=True)
class Settings:
    """The configuration.

    Attributes:
        is_synthesis_enabled: containers may be filled by synthesis, on pages and by command.
        synthesis_topic: action of the synthesis server that is asked; empty: the console itself
            synthesizes.
        system: name of the robot system, sent to the synthesis server.
        are_commands_allowed: commands of `/flexbe/uicommand` are taken.
        command_key: the key that such a command must contain; empty: none.
        chart_folders: absolute paths of folders with charts, besides those of the packages.
        plots: fields of topics that are plotted beside the run, `/TOPIC.FIELD`.
    """

    is_synthesis_enabled: bool = True
    synthesis_topic: str = ""
    system: str = ""
    are_commands_allowed: bool = True
    command_key: str = ""
    chart_folders: tuple[str, ...] = ()
    plots: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Refuse what cannot be meant.

        Raises:
            ValueError: if a text is too long or of several lines, a folder is not absolute, or a
                plot is none, there twice, or one too many.
        """
        fields = (self.synthesis_topic, self.system, self.command_key)
        texts = (*fields, *self.chart_folders, *self.plots)
        for text in texts:
            if len(text) > _LONGEST or not text.isprintable():
                raise ValueError(f"{text[:20]!r}... is no text of one line, {_LONGEST} letters")
        for folder in self.chart_folders:
            if not posixpath.isabs(folder):
                raise ValueError(f"'{folder}' is no absolute path; a folder begins with '/'")
        for plot in self.plots:
            split_plot(plot)
            if self.plots.count(plot) > 1:
                raise ValueError(f"{plot} is plotted already")
        if len(self.plots) > MOST_PLOTS:
            raise ValueError(f"at most {MOST_PLOTS} fields are plotted; remove one of them first")


def write_settings(settings: Settings) -> str:
    """Return the text of a settings file."""
    return json.dumps(asdict(settings), indent=2, ensure_ascii=False) + "\n"


def read_settings(text: str) -> Settings:
    """Return the settings that a text says; what it leaves out is as at the first start.

    Raises:
        ValueError: if it is no settings file, says something unknown, or of another type.
    """
    found = json.loads(text)
    if not isinstance(found, dict):
        raise ValueError("it holds no JSON object")
    known = {field.name for field in fields(Settings)}
    strange = sorted(set(found) - known)
    if strange:
        raise ValueError(f"unknown: {', '.join(strange)}; known: {', '.join(sorted(known))}")
    kinds = get_type_hints(Settings)
    for name, value in found.items():
        if kinds[name] in (bool, str) and type(value) is not kinds[name]:
            raise ValueError(f"{name} is {value!r}, not a {kinds[name].__name__}")
    for name, words in (("chart_folders", "paths"), ("plots", "fields of topics")):
        texts = found.get(name, [])
        if not isinstance(texts, list) or not all(isinstance(one, str) for one in texts):
            raise ValueError(f"{name} is {texts!r}, not a list of {words}")
        found[name] = tuple(texts)
    return Settings(**found)


def difference(old: Settings, new: Settings) -> str:
    """Return what changes from one to the other, for the record; it does not contain keys."""
    parts = []
    for field in fields(Settings):
        before, after = getattr(old, field.name), getattr(new, field.name)
        if before != after:
            value = "changed" if field.name == "command_key" else f"= {_words(after)}"
            parts.append(f"{field.name} {value}")
    return "; ".join(parts) or "nothing"


def _words(value: object) -> str:
    return ":".join(value) if isinstance(value, tuple) else repr(value)


_HIDDEN = "-"


@dataclass(frozen=True)
class PagePart:
    """A part of a page; `area` is the column in which it stands."""

    title: str
    area: str
    is_shown: bool = True


def arranged(parts: Sequence[PagePart], text: str) -> tuple[PagePart, ...]:
    """Return parts as a text of `arrangement_text` has them.

    Parts that it does not name, as after an upgrade, follow; what it names and is none is left out.
    """
    known = {part.title: part for part in parts}
    named = {}
    for word in text.split(","):
        title = word.removeprefix(_HIDDEN)
        if title in known:
            named[title] = replace(known[title], is_shown=title == word)
    return (*named.values(), *(part for part in parts if part.title not in named))


def arrangement_text(parts: Sequence[PagePart]) -> str:
    """Return an arrangement as a text that a browser can keep."""
    return ",".join(("" if part.is_shown else _HIDDEN) + part.title for part in parts)


def with_shown(parts: Sequence[PagePart], title: str, *, is_shown: bool) -> tuple[PagePart, ...]:
    """Return the parts with one shown or hidden."""
    return tuple(replace(p, is_shown=is_shown) if p.title == title else p for p in parts)


def moved(parts: Sequence[PagePart], title: str, step: int) -> tuple[PagePart, ...]:
    """Return the parts with one moved up (-1) or down (1) in its area; the first cannot go up."""
    found = list(parts)
    index = next(place for place, part in enumerate(found) if part.title == title)
    beside = [place for place, part in enumerate(found) if part.area == found[index].area]
    there = beside.index(index) + step
    if 0 <= there < len(beside):
        other = beside[there]
        found[index], found[other] = found[other], found[index]
    return tuple(found)
