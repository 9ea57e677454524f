"""The columns of a wire list, and the mapping that a person makes of them by choosing."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

import yaml

from remodel_console.errors import CommandError

_FORMAT = "remodel-wire-list-1"
NOT_USED = ""
SECTION_UNITS = ("mm2", "awg")
LENGTH_UNITS = ("mm", "cm", "m", "in", "ft")
_ENDS = {"from": "First end", "to": "Second end"}
_PARTS = {
    "": "component and terminal",
    "_component": "component",
    "_terminal": "terminal",
    "_x": "x of the component",
    "_y": "y of the component",
    "_seal": "seal",
    "_force_limit": "greatest insertion force [N]",
    "_place": "plate, door or outside",
}
_WORDS = {
    **{
        f"{end}{part}": f"{name}: {words}"
        for end, name in _ENDS.items()
        for part, words in _PARTS.items()
    },
    "wire": "Wire",
    "colour": "Colour",
    "section": "Section",
    "length": "Length",
    "cable": "Cable",
    "core": "Core of the cable",
    "twisted": "Group of twisted wires",
    "component": "One end in a line: component",
    "terminal": "One end in a line: terminal",
    "place": "One end in a line: plate, door or outside",
}


@dataclass(frozen=True)
class ListColumns:
    """The columns of a list, and what they mean as far as that is known.

    Attributes:
        rows: the first ones below the headings.
        fields: all that a column can mean.
        columns: heading of each field's column.
        units: of section, length and position.
        separator: of cells.
        terminal_separator: of the component and the terminal in a cell.
    """

    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    fields: tuple[str, ...]
    columns: dict[str, str]
    units: dict[str, str]
    separator: str
    terminal_separator: str

    def meaning(self, heading: str) -> str:
        """Return the field of a column; `NOT_USED` if it has none."""
        return next((f for f, found in self.columns.items() if found == heading), NOT_USED)

    @property
    def has_ends(self) -> bool:
        """Return whether it is known where the ends of wires are."""
        known = self.columns.keys()
        return known >= {"wire", "component", "terminal"} or all(
            known & {end, f"{end}_component"} for end in _ENDS
        )

    @property
    def choices(self) -> dict[str, str]:
        """Return what a column can mean, in words, by field."""
        return {NOT_USED: "not used"} | {f: _WORDS.get(f, f) for f in self.fields}

    def mapping(
        self, meanings: Mapping[str, str], units: Mapping[str, str], terminal_separator: str
    ) -> str:
        """Return the YAML of a mapping in which columns have chosen meanings.

        Args:
            meanings: fields by heading.
            units: of section and length.
            terminal_separator: of the component and the terminal in a cell.

        Raises:
            CommandError: if two columns mean the same.
        """
        chosen = {heading: field for heading, field in meanings.items() if field != NOT_USED}
        for field, count in Counter(chosen.values()).items():
            if count > 1:
                both = " and ".join(f"'{h}'" for h, each in chosen.items() if each == field)
                raise CommandError(
                    f"{both} are both '{self.choices[field]}': choose another meaning for one"
                )
        document = {
            "format": _FORMAT,
            "columns": {field: heading for heading, field in chosen.items()},
            "units": {**self.units, **units},
            "separator": self.separator,
            "terminal_separator": terminal_separator or self.terminal_separator,
        }
        return yaml.safe_dump(document, sort_keys=False, allow_unicode=True)
