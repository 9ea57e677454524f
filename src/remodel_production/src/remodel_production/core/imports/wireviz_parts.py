"""Connectors and cables of a WireViz file: their pins and cores, and how a file refers to them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import cycle, islice

from remodel_production.core.imports.documents import Value, section_of
from remodel_production.core.imports.values import LeftOut, length_m
from remodel_production.errors import DesignError

# DIN 47100, cores 1 to 44.
_DIN = [
    *("WH", "BN", "GN", "YE", "GY", "PK", "BU", "RD", "BK", "VT", "GYPK", "RDBU", "WHGN", "BNGN"),
    *("WHYE", "YEBN", "WHGY", "GYBN", "WHPK", "PKBN", "WHBU", "BNBU", "WHRD", "BNRD", "WHBK"),
    *("BNBK", "GYGN", "YEGY", "PKGN", "YEPK", "GNBU", "YEBU", "GNRD", "YERD", "GNBK", "YEBK"),
    *("GYBU", "PKBU", "GYRD", "PKRD", "GYBK", "PKBK", "BUBK", "RDBK"),
]
# The 25-pair colour code: five tip colours, each with five ring colours.
_TIPS, _RINGS = ("WH", "RD", "BK", "YE", "VT"), ("BU", "OG", "GN", "BN", "SL")

_CODES = {
    "DIN": _DIN,
    "IEC": ["BN", "RD", "OG", "YE", "GN", "BU", "VT", "GY", "WH", "BK"],
    "BW": ["BK", "WH"],
    "TEL": [code for tip in _TIPS for ring in _RINGS for code in (ring + tip, tip + ring)],
    "TELALT": [
        code
        for tip in _TIPS
        for ring in _RINGS
        for code in (tip + ring, ring if tip == "WH" else ring + tip)
    ],
    "T568A": ["WHGN", "GN", "WHOG", "BU", "WHBU", "OG", "WHBN", "BN"],
    "T568B": ["WHOG", "OG", "WHGN", "BU", "WHBU", "GN", "WHBN", "BN"],
}
COLOUR_CODES = tuple(_CODES)


def core_colours(code: str, count: int) -> list[str]:
    """Return the colours of the first cores by a code of COLOUR_CODES; they begin again."""
    return list(islice(cycle(_CODES[code]), count))


SHIELD = "s"

_RANGE = re.compile(r"(\d+)\s*-\s*(\d+)")
# A connector has hundreds of pins and a cable hundreds of cores at most.
_MOST_PINS = 2000


@dataclass(frozen=True)
class Pinout:
    """What a connector or a cable has, by its key and, for some, by a label or a colour.

    Attributes:
        what: for errors, such as "connector X1".
        noun: "pin" or "core".
        labels: of the keys, in their order; empty where there is none.
        colours: likewise, of cores.
        extra: keys besides, such as the shield.
    """

    what: str
    noun: str
    keys: tuple[str, ...]
    labels: tuple[str, ...] = ()
    colours: tuple[str, ...] = ()
    extra: tuple[str, ...] = ()

    def expanded(self, reference: Value) -> list[str]:
        """Return the keys that a reference means: one, a range "1-4" or "4-1", or a list of them.

        Raises:
            DesignError: if the part has no such pin or core.
        """
        references = [reference] if reference.is_scalar else reference.items(self.what)
        return [key for item in references for key in self._keys_of(item)]

    def _keys_of(self, reference: Value) -> list[str]:
        text = reference.text.strip()
        match = _RANGE.fullmatch(text)
        if match is None or text in self.keys or text in self.labels:
            return [self._key_of(text, reference)]
        first, last = int(match[1]), int(match[2])
        if abs(last - first) >= _MOST_PINS:
            raise DesignError(f"{reference.where}: {self.what}: {text} are too many")
        step = 1 if first <= last else -1
        return [self._key_of(str(n), reference) for n in range(first, last + step, step)]

    def _key_of(self, text: str, reference: Value) -> str:
        if text in self.keys or text in self.extra:
            return text
        for names, what in ((self.labels, "label"), (self.colours, "colour")):
            found = [key for key, name in zip(self.keys, names, strict=False) if name == text]
            if len(found) == 1:
                return found[0]
            if found:
                raise DesignError(
                    f"{reference.where}: {self.what}: {what} {text} stands for {self.noun}s "
                    f"{', '.join(found)}: name one of them by its number"
                )
        known = ", ".join((*self.keys[:20], *self.extra)) or "none"
        names_known = ", ".join(name for name in self.labels if name)
        raise DesignError(
            f"{reference.where}: {self.what} has no {self.noun} {text or 'without a name'}; it has "
            f"{known}" + (f"; labels: {names_known}" if names_known else "")
        )


@dataclass(frozen=True)
class ConnectorPart:
    """A connector, or the template of some."""

    pinout: Pinout
    kind: str
    part_number: str
    loops: int
    line: int


@dataclass(frozen=True)
class CablePart:
    """A cable or bundle, or the template of some.

    Attributes:
        gauges: of its cores, as the file has them; empty if it has none.
        lengths: likewise.
        is_bundle: whether its cores are single wires.
    """

    pinout: Pinout
    kind: str
    gauges: tuple[str, ...]
    lengths: tuple[str, ...]
    is_shielded: bool
    is_bundle: bool
    line: int

    def colour_of(self, core: str) -> str:
        """Return a core's colour as the file has it; empty if it has none."""
        index = self.pinout.keys.index(core) if core in self.pinout.keys else -1
        return self.pinout.colours[index] if 0 <= index < len(self.pinout.colours) else ""

    def gauge_of(self, core: str) -> str:
        """Return a core's gauge as the file has it; empty if it has none."""
        return self._of_core(self.gauges, core)

    def length_of(self, core: str) -> float | None:
        """Return a core's length [m]; None if the file has none that is understood."""
        return length_m(self._of_core(self.lengths, core))

    @property
    def length_m(self) -> float | None:
        """The length [m] of all its cores; None if the file has none, or several."""
        return length_m(self.lengths[0]) if len({*self.lengths}) == 1 else None

    def _of_core(self, values: tuple[str, ...], core: str) -> str:
        """Return a core's value; a shield has that of the cores if they have the same."""
        if core in self.pinout.keys and values:
            return values[self.pinout.keys.index(core)]
        return values[0] if len({*values}) == 1 else ""


def connector_part(name: str, value: Value) -> ConnectorPart:
    """Read the attributes of a connector.

    Raises:
        DesignError: if its pins are not said, or contradict each other.
    """
    what = f"connector {name}"
    attributes = value.mapping(what)
    is_simple = _text(attributes, "style") == "simple"
    pins = _texts(attributes, "pins", what)
    labels = _texts(attributes, "pinlabels", what)
    said = _count(attributes, "pincount", what) or max(len(pins), len(labels))
    count = said or (1 if is_simple else 0)
    if not count:
        raise DesignError(f"{value.where}: {what}: give its pincount, pins or pinlabels")
    if max(len(pins), len(labels)) > count:
        raise DesignError(
            f"{value.where}: {what}: pincount is {count}; there are {len(pins)} pins and "
            f"{len(labels)} pinlabels"
        )
    keys = pins or [str(n) for n in range(1, count + 1)]
    _refuse_doubles(keys, "pin", what, value)
    return ConnectorPart(
        Pinout(what, "pin", tuple(keys), tuple(labels)),
        " ".join(filter(None, (_text(attributes, "type"), _text(attributes, "subtype")))),
        _text(attributes, "mpn") or _text(attributes, "pn"),
        loops=len(attributes["loops"].items("loops")) if "loops" in attributes else 0,
        line=value.line,
    )


def cable_part(name: str, value: Value) -> CablePart:
    """Read the attributes of a cable.

    Raises:
        DesignError: if its cores are not said, or its colour code is not known.
    """
    what = f"cable {name}"
    attributes = value.mapping(what)
    colours = _texts(attributes, "colors", what)
    count = _count(attributes, "wirecount", what) or len(colours)
    code = _text(attributes, "color_code").upper()
    if not count:
        raise DesignError(f"{value.where}: {what}: give its wirecount or colors")
    if code and code not in COLOUR_CODES:
        where = attributes["color_code"].where
        raise DesignError(
            f"{where}: {what}: color_code {code} is not known; allowed: {', '.join(COLOUR_CODES)}"
        )
    if code and not colours:
        colours = core_colours(code, count)
    colours = [colours[i % len(colours)] for i in range(count)] if colours else []
    is_shielded = "shield" in attributes and attributes["shield"].data not in (None, False)
    return CablePart(
        Pinout(
            what,
            "core",
            tuple(str(n) for n in range(1, count + 1)),
            tuple(_texts(attributes, "wirelabels", what)),
            colours=tuple(colours),
            extra=(SHIELD,) if is_shielded else (),
        ),
        _text(attributes, "type") or _text(attributes, "mpn") or _text(attributes, "pn"),
        _of_cores(attributes, "gauge", count, what),
        _of_cores(attributes, "length", count, what),
        is_shielded=is_shielded,
        is_bundle=_text(attributes, "category") == "bundle",
        line=value.line,
    )


def _text(attributes: dict[str, Value], key: str) -> str:
    """Return a scalar attribute on one line; empty if it is not there, or not a scalar."""
    value = attributes.get(key)
    return " ".join(value.text.split()) if value is not None and value.is_scalar else ""


def _texts(attributes: dict[str, Value], key: str, what: str) -> list[str]:
    if key not in attributes:
        return []
    items = attributes[key].items(f"{what}, {key}")
    if len(items) > _MOST_PINS:
        raise DesignError(f"{attributes[key].where}: {what}, {key}: at most {_MOST_PINS} allowed")
    return [item.text.strip() for item in items]


def _of_cores(attributes: dict[str, Value], key: str, count: int, what: str) -> tuple[str, ...]:
    """Return an attribute of each core: one for all, or a list; empty if it is not there."""
    value = attributes.get(key)
    if value is None or value.data in (None, ""):
        return ()
    if value.is_scalar:
        return (_text(attributes, key),) * count
    values = value.items(f"{what}, {key}")
    if len(values) != count or not all(each.is_scalar for each in values):
        raise DesignError(
            f"{value.where}: {what}: {key}: {len(values)} values found for {count} cores; give one "
            "for all, or one for each"
        )
    return tuple(" ".join(each.text.split()) for each in values)


def _count(attributes: dict[str, Value], key: str, what: str) -> int:
    if key not in attributes or attributes[key].data is None:
        return 0
    count = attributes[key].data
    if not isinstance(count, int) or isinstance(count, bool) or not 0 < count <= _MOST_PINS:
        raise DesignError(
            f"{attributes[key].where}: {what}: {key}: {attributes[key].shown} found; a number from "
            f"1 to {_MOST_PINS} is needed"
        )
    return count


def _refuse_doubles(keys: Sequence[str], noun: str, what: str, value: Value) -> None:
    seen: set[str] = set()
    for key in keys:
        if key in seen:
            raise DesignError(f"{value.where}: {what}: {noun} {key} is given twice: keep one")
        seen.add(key)


def omitted_parts(root: Mapping[str, Value]) -> Iterator[LeftOut]:
    """Yield the parts of a file, such as seals and labels, that no task mounts."""
    for section in ("connectors", "cables"):
        for name, value in section_of(root, section).items():
            more = value.mapping(name).get("additional_components")
            for part in more.items("additional_components") if more else []:
                yield LeftOut(part.where, f"no task mounts {_title(part)} of {name}")
    items = root.get("additional_bom_items")
    for part in items.items("additional_bom_items") if items else []:
        yield LeftOut(part.where, f"no task mounts {_title(part)}")


def _title(part: Value) -> str:
    entries = part.data if isinstance(part.data, dict) else {"description": part}
    stated = [entries[key] for key in ("type", "subtype", "description") if key in entries]
    return " ".join(each.text for each in stated if each.is_scalar) or "a part without a type"
