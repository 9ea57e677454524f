"""Which column of a from-to list means what: the YAML that comes with a list, and its form.

format: remodel-wire-list-1
name: of the orders; if it is not given, the name of the list's file
columns:                    # a column's heading, or a list of headings of which one is there
  from: Source              # component and terminal in one cell, or
  from_component: From Tag  # ... in two
  from_terminal: From Terminal
  to: Target                # likewise to_component, to_terminal; or, for all four of these,
  component: Connector      # in a list with a line for each end of a wire, which `wire` names:
  terminal: Pin             # component and terminal
  wire: Number              # and, all optional: colour, section, length, cable, core, and the
  ...                       # articles of seals: from_seal, to_seal; the group of twisted wires:
  ...                       # twisted; the place of the components: from_x, from_y, to_x, to_y; the
  ...                       # most with which an end may be pushed in [N]: from_force_limit, to_...;
  ...                       # where the components are, plate, door or outside: from_place, to_place
units: {section: mm2, length: mm, position: mm}       # of numbers without one
terminal_separator: ":"     # the last one in a cell separates component and terminal
separator: ";"              # of cells; if it is not given, the one that fits the headings
sheet: Wires                # of a workbook; if it is not given, the one that fits the headings
encoding: cp1252            # if it is not given: by the file's mark, else UTF-8
synonyms: true              # further columns are found by headings in usual words of five languages
colours: {hellblau: BU}     # names besides those of the catalogue
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from remodel_production.core.imports.documents import Value, parse_yaml, section_of
from remodel_production.core.imports.values import is_length_unit
from remodel_production.errors import DesignError

FORMAT = "remodel-wire-list-1"


class Field(Enum):
    """What a column can mean; the value is the word of the mapping."""

    FROM = "from"
    FROM_COMPONENT = "from_component"
    FROM_TERMINAL = "from_terminal"
    TO = "to"
    TO_COMPONENT = "to_component"
    TO_TERMINAL = "to_terminal"
    WIRE = "wire"
    COLOUR = "colour"
    SECTION = "section"
    LENGTH = "length"
    CABLE = "cable"
    CORE = "core"
    FROM_X = "from_x"
    FROM_Y = "from_y"
    TO_X = "to_x"
    TO_Y = "to_y"
    FROM_SEAL = "from_seal"
    TO_SEAL = "to_seal"
    TWISTED = "twisted"
    FROM_FORCE_LIMIT = "from_force_limit"
    TO_FORCE_LIMIT = "to_force_limit"
    FROM_PLACE = "from_place"
    TO_PLACE = "to_place"
    COMPONENT = "component"
    TERMINAL = "terminal"
    PLACE = "place"


# What a list with a line for each end of a wire has instead of its two ends.
PIN_LIST = (Field.WIRE, Field.COMPONENT, Field.TERMINAL)
ENDS = ((Field.FROM, Field.FROM_COMPONENT), (Field.TO, Field.TO_COMPONENT))
_KEYS = (
    *("format", "name", "columns", "units", "terminal_separator", "separator", "encoding"),
    *("sheet", "synonyms", "colours"),
)
_SECTION_UNITS = ("mm2", "awg")


@dataclass(frozen=True)
class WireListMapping:
    """Which column of a list means what.

    Attributes:
        name: title of the orders; empty for the name of the file.
        columns: headings in lower case; one of each field's headings names its column.
        section_unit: of sections without one, "mm2" or "awg".
        length_unit: of lengths without one.
        position_unit: of positions.
        separator: of cells; empty if it is to be found.
        encoding: of the file; empty if it is to be found.
        sheet: of a workbook; empty if it is to be found.
        colours: codes by names in lower case.
        has_synonyms: whether a column that it does not list may be found by the usual words.
    """

    name: str
    columns: Mapping[Field, tuple[str, ...]]
    section_unit: str = "mm2"
    length_unit: str = "mm"
    position_unit: str = "mm"
    terminal_separator: str = ":"
    separator: str = ""
    encoding: str = ""
    sheet: str = ""
    colours: Mapping[str, str] | None = None
    has_synonyms: bool = False

    def found_in(self, headings: list[str]) -> dict[Field, int]:
        """Return the number of each listed field's column.

        Args:
            headings: of which the second "Pin" is "Pin#2".
        """
        lower = [heading.strip().lower() for heading in headings]
        return {
            column: lower.index(name)
            for column, names in self.columns.items()
            for name in names[::-1]
            if name in lower
        }


def mapping_from(text: str) -> WireListMapping:
    """Read a mapping.

    Raises:
        DesignError: naming the line, what was found, and what is allowed.
    """
    root = parse_yaml(text).mapping("the mapping", _KEYS)
    if "format" not in root or root["format"].data != FORMAT:
        found = root["format"].shown if "format" in root else "none"
        raise DesignError(f"line 1: format {found} found; `format: {FORMAT}` is needed")
    if "columns" not in root:
        raise DesignError("line 1: `columns` is missing; it says which column means what")
    units = section_of(root, "units", ("section", "length", "position"))
    colours = section_of(root, "colours")
    return WireListMapping(
        _text(root, "name", ""),
        _columns(root["columns"]),
        _unit(units, "section", "mm2"),
        _unit(units, "length", "mm"),
        position_unit=_unit(units, "position", "mm"),
        terminal_separator=_text(root, "terminal_separator", ":"),
        separator=_text(root, "separator", "").replace("tab", "\t"),
        encoding=_text(root, "encoding", ""),
        sheet=_text(root, "sheet", ""),
        colours={name.lower(): code.text.upper() for name, code in colours.items()},
        has_synonyms=_flag(root, "synonyms"),
    )


@dataclass(frozen=True)
class MappingDraft:
    """A mapping to correct, and the list that it is of.

    Attributes:
        headings: of which the second "Pin" is "Pin#2".
        rows: the first ones below them.
        columns: heading of each field's column.
        units: of section, length and position.
        separator: of cells.
        terminal_separator: of the component and the terminal in a cell.
    """

    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    columns: Mapping[Field, str]
    units: Mapping[str, str]
    separator: str
    terminal_separator: str

    @property
    def document(self) -> dict[str, object]:
        """Return it as JSON, with all that a column can mean."""
        return {
            "headings": self.headings,
            "rows": self.rows,
            "fields": [field.value for field in Field],
            "columns": {field.value: heading for field, heading in self.columns.items()},
            "units": dict(self.units),
            "separator": self._separator,
            "terminal_separator": self.terminal_separator,
        }

    @property
    def text(self) -> str:
        """Return its YAML, in which comments list what is missing and not used."""
        columns = self.columns
        lines = [f"format: {FORMAT}", "columns:"]
        lines += [f"  {field.value}: {_quoted(heading)}" for field, heading in columns.items()]
        for whole, component in () if Field.COMPONENT in columns else ENDS:
            if whole not in columns and component not in columns:
                lines.append(f"  # missing: {whole.value}, or {component.value}")
        used = set(columns.values())
        fields = ", ".join(field.value for field in Field if field not in columns)
        unused = [heading for heading in self.headings if heading and heading not in used]
        lines += [f"  # not used: {_quoted(heading)}" for heading in unused]
        lines.append(f"  # columns without a heading yet: {fields}")
        lines.append(
            "units: {" + ", ".join(f"{key}: {unit}" for key, unit in self.units.items()) + "}"
        )
        lines.append(f"separator: {_quoted(self._separator)}")
        lines.append(f"terminal_separator: {_quoted(self.terminal_separator)}")
        return "\n".join(lines) + "\n"

    @property
    def _separator(self) -> str:
        return "tab" if self.separator == "\t" else self.separator


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)


def _columns(value: Value) -> dict[Field, tuple[str, ...]]:
    columns = value.mapping("columns", [field.value for field in Field])
    found = {}
    for key, heading in columns.items():
        names = [heading] if heading.is_scalar else heading.items(f"column {key}")
        if not names or not all(name.is_scalar and name.text.strip() for name in names):
            raise DesignError(f"{heading.where}: column {key}: give a heading, or a list of them")
        found[Field(key)] = tuple(name.text.strip().lower() for name in names)
    for whole, component in () if found.keys() >= {*PIN_LIST} else ENDS:
        if whole not in found and component not in found:
            raise DesignError(
                f"{value.where}: columns: neither `{whole.value}` nor `{component.value}` is "
                "given; each wire has two ends, or a line for each with `wire`, `component` and "
                "`terminal`"
            )
    return found


def _unit(units: dict[str, Value], key: str, default: str) -> str:
    unit = units[key].text.lower() if key in units else default
    allowed = unit in _SECTION_UNITS if key == "section" else is_length_unit(unit)
    if not allowed:
        known = "mm2, awg" if key == "section" else "mm, cm, m, in, ft"
        raise DesignError(f"{units[key].where}: unit of {key}: {unit} found; allowed: {known}")
    return unit


def _text(entries: dict[str, Value], key: str, default: str) -> str:
    if key not in entries:
        return default
    if not entries[key].is_scalar or not entries[key].text:
        raise DesignError(f"{entries[key].where}: {key}: a text is needed")
    return entries[key].text


def _flag(entries: dict[str, Value], key: str) -> bool:
    if key not in entries:
        return False
    value = entries[key].data
    if not isinstance(value, bool):
        raise DesignError(
            f"{entries[key].where}: {key}: {entries[key].shown} found; allowed: true, false"
        )
    return value
