"""The preferences of an order's plan, as they are edited: entries under `prefer` and `require`.

docs/planning.md describes the document. What an entry means is checked by the planner alone; here
it only has its fields.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import yaml

from remodel_console.errors import CommandError

_FORMAT = "remodel-preferences-1"
_LONGEST = 100_000  # letters of a document
_LISTS = ("prefer", "require")
_ALL = "all"
Document = dict[str, Any]


@dataclass(frozen=True)
class EntryKind:
    """A kind of entry: the list that it stands in, its fields in their order, and what it says."""

    list_name: str
    fields: tuple[str, ...]
    meaning: str

    @property
    def is_required(self) -> bool:
        """Return whether no plan may violate it."""
        return self.list_name == "require"


KINDS = (
    EntryKind("prefer", ("pick", "before", "weight"), "Pick some wires before others"),
    EntryKind("prefer", ("pick", "in_order_of", "from", "weight"), "Pick wires in an order"),
    EntryKind("prefer", ("pick", "with_arm"), "Pick wires with one of the arms"),
    EntryKind("require", ("route", "before"), "Route some wires below others"),
    EntryKind("require", ("route", "in_order_of", "from"), "Route wires in an order"),
    EntryKind("require", ("arm", "x_mm"), "Limit where an arm works"),
    EntryKind("require", ("arm", "out_of"), "Keep an arm out of a zone"),
    EntryKind("require", ("avoid_segment",), "Route no wire through a segment"),
    EntryKind("require", ("insert", "force_n"), "Limit the force of insertions"),
)
FIELD_HINTS = {
    "pick": "all, W1, [W1, W2] or {colour: BU}",
    "before": "all, W1, [W1, W2] or {colour: BU}",
    "route": "all, W1, [W1, W2] or {colour: BU}",
    "insert": "all, W1, [W1, W2] or {colour: BU}",
    "in_order_of": "such as section_mm2",
    "from": "least or greatest",
    "weight": "cost of each violation, in ticks of 0.1 s",
    "with_arm": "name of an arm",
    "arm": "name of an arm",
    "x_mm": "[least, greatest], in mm of the board",
    "out_of": "name under `zones`",
    "avoid_segment": "name of a segment of the board",
    "force_n": "the most, in N",
}
WIRE_FIELDS = ("pick", "before", "route", "insert")  # that select wires


def new_document() -> Document:
    """Return a document without entries."""
    return {"format": _FORMAT}


def entries(document: Document, list_name: str) -> tuple[Mapping[str, Any], ...]:
    """Return the entries of a list."""
    return tuple(document.get(list_name) or ())


def has_entries(document: Document) -> bool:
    """Return whether a document says anything."""
    return set(document) > {"format"}


def new_entry(kind: EntryKind, name: str, texts: Mapping[str, str]) -> Document:
    """Return an entry of the texts that were filled in, each the YAML of a value.

    Raises:
        CommandError: naming the first field that is empty or no YAML.
    """
    if not name.strip():
        raise CommandError("name: give the entry a name; explanations and conflicts refer to it")
    entry: Document = {"name": name.strip()}
    for field in kind.fields:
        text = texts.get(field, "").strip()
        if not text:
            raise CommandError(f"{field}: fill it in, such as: {FIELD_HINTS[field]}")
        try:
            entry[field] = _parsed(text)
        except CommandError as error:
            raise CommandError(f"{field}: {error}; such as: {FIELD_HINTS[field]}") from error
    return entry


def chosen_wires(text: str) -> tuple[str, ...] | None:
    """Return the wires that the text of a field names; None if it is anything else, as `all`."""
    try:
        value = _parsed(text)
    except CommandError:
        return None
    if isinstance(value, str) and value != _ALL:
        return (value,)
    names = [] if value is None else value
    is_names = isinstance(names, list) and all(isinstance(each, str) for each in names)
    return tuple(names) if is_names else None  # type: ignore[arg-type]  # a list, as just checked


def with_clicked(text: str, wires: Sequence[str]) -> str:
    """Return the text of a field after a click on wires: it names all of them, or no longer any.

    Raises:
        CommandError: if the text selects wires in another way; what a person has typed is kept.
    """
    chosen = chosen_wires(text)
    if chosen is None:
        raise CommandError(f"`{text.strip()}` is no list of wires; clear the field to click wires")
    if set(wires) <= set(chosen):
        left = [name for name in chosen if name not in wires]
    else:
        left = list(dict.fromkeys((*chosen, *wires)))
    return _flow(left) if left else ""


def with_entry(document: Document, list_name: str, entry: Document) -> Document:
    """Return a document with one more entry."""
    return {**document, list_name: [*entries(document, list_name), entry]}


def without_entry(document: Document, list_name: str, entry: Mapping[str, Any]) -> Document:
    """Return a document without an entry; if another person has removed it, as it is."""
    left = list(entries(document, list_name))
    if entry in left:
        left.remove(entry)
    changed = {**document, list_name: left}
    return changed if left else {name: v for name, v in changed.items() if name != list_name}


def entry_words(entry: Mapping[str, Any]) -> str:
    """Return what an entry says besides its name."""
    fields = {name: value for name, value in entry.items() if name != "name"}
    return _flow(fields)[1:-1]


def write_document(document: Document) -> str:
    """Return the YAML of a document, an entry per line."""
    parts = []
    for key, value in document.items():
        if key in _LISTS:
            parts.append("".join((f"{key}:\n", *(f"  - {_flow(each)}\n" for each in value))))
        else:
            parts.append(yaml.safe_dump({key: value}, sort_keys=False))
    return "".join(parts)


def read_document(text: str) -> Document:
    """Return the document that a text is, as far as its form matters for editing it.

    Raises:
        CommandError: if it has no such form, with the place.
    """
    if not text.strip():
        return new_document()
    document = _parsed(text)
    if not isinstance(document, dict) or document.get("format") != _FORMAT:
        raise CommandError(f"the preferences begin with `format: {_FORMAT}`")
    for name in _LISTS:
        found = document.get(name, [])
        if not isinstance(found, list) or not all(isinstance(each, dict) for each in found):
            raise CommandError(f"`{name}` holds a list of entries, such as `- {{name: ..., ...}}`")
    return document


def _flow(value: object) -> str:
    """Return the YAML of a list or a mapping, in one line."""
    text: str = yaml.safe_dump(
        value, default_flow_style=True, sort_keys=False, width=_LONGEST, allow_unicode=True
    )
    return text.rstrip("\n")


def _parsed(text: str) -> object:
    """Return the value of a YAML text; one that refers to itself is refused."""
    if len(text) > _LONGEST:
        raise CommandError(f"longer than {_LONGEST} letters")
    try:
        value = yaml.safe_load(text)  # first: it gives up on deep nesting soon
        if any(isinstance(event, yaml.AliasEvent) for event in yaml.parse(text, yaml.SafeLoader)):
            raise CommandError("aliases (`*name`) are not allowed; repeat the value")
        return value
    except (yaml.YAMLError, RecursionError, ValueError) as error:
        mark = getattr(error, "problem_mark", None)
        where = f"line {mark.line + 1}: " if mark else ""
        what = getattr(error, "problem", None) or "nested too deeply or malformed"
        raise CommandError(f"{where}is no YAML: {what}") from error
