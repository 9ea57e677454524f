"""What the headings of a wire list mean, by the words that people use for them.

A heading is split into words, German compounds into their parts ("Zielklemme": ziel, klemme). Words
for one end and words for a component or a terminal together name a field ("From Pin", "Borne
départ"); so do words for a colour, a section or a length alone ("Aderfarbe", "Longueur du fil").
An abbreviation with a point stands for the words that begin like it ("Querschn.", "Lungh."). A
heading with a word that is not listed has no meaning: better a column that the account names than
one misread.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from enum import Enum, auto
from functools import cache, lru_cache

from remodel_production.core.imports.wire_list_mapping import Field


class _Kind(Enum):
    """What a word of a heading stands for."""

    FROM = auto()
    TO = auto()
    COMPONENT = auto()
    TERMINAL = auto()
    WIRE = auto()
    COLOUR = auto()
    SECTION = auto()
    LENGTH = auto()
    CABLE = auto()
    CORE = auto()
    SIGNAL = auto()
    SEAL = auto()
    TWISTED = auto()
    PLACE = auto()
    FILLER = auto()


# English; German; French; Italian; Spanish. Without accents.
_WORDS: Mapping[_Kind, str] = {
    _Kind.FROM: "from source start starting origin begin first src startpoint left initial; von "
    "quelle quell anfang herkunft startpunkt anfangspunkt links linke linker linkes; "
    "depart depuis origine tenant gauche initiale; partenza iniziale sorgente "
    "provenienza sinistra sinistro; origen desde inicio procedencia izquierda "
    "izquierdo inicial",
    _Kind.TO: "to target destination dest dst sink second ending endpoint right final terminus; "
    "nach ziel endpunkt zielpunkt rechts rechte rechter rechtes; vers arrivee destination "
    "aboutissant droite droit finale cible; verso destinazione arrivo destra destro; "
    "destino hacia hasta derecha derecho",
    _Kind.COMPONENT: "component device connector designator equipment refdes ref reference plug "
    "item unit node termination housing conn comp dev terminalstrip equip eqpt socket "
    "header jack receptacle; gerat geraet bauteil bauelement betriebsmittel bmk "
    "stecker steckverbinder komponente gehause gehaeuse klemmleiste; composant "
    "appareil connecteur equipement element bornier prise fiche; componente "
    "dispositivo connettore apparecchio punto morsettiera; conector equipo aparato "
    "elemento regleta",
    _Kind.TERMINAL: "terminal term pin cavity contact position pos slot cav way point points; "
    "klemme kammer kl anschluss kontakt pol buchse stift; borne broche alveole voie cavite; "
    "morsetto cavita piedino contatto polo terminale; contacto cavidad borna via",
    _Kind.WIRE: "wire wires wiring lead circuit ckt connection; draht leitung leitungs ltg litze "
    "verbindung verbindungs leiter; fil conducteur liaison repere; filo conduttore "
    "collegamento; hilo conductor circuito",
    _Kind.COLOUR: "colour color col clr; farbe farb fb; couleur coul coloris teinte; colore",
    _Kind.SECTION: "section gauge gage ga size crosssection csa xsection; querschnitt qs; jauge "
    "calibre; sezione; seccion calibre galga",
    _Kind.LENGTH: "length len; lange laenge; longueur lg; lunghezza; longitud largo",
    _Kind.CABLE: "cable multicore; kabel mehraderleitung; cavo multipolare; multipolar",
    _Kind.CORE: "core; ader; brin; anima",
    _Kind.SIGNAL: "signal signals net netname potential; netz potenzial; potentiel; segnale",
    _Kind.SEAL: "seal seals; dichtung ead; joint; guarnizione; sello",
    _Kind.TWISTED: "twist twisted pair; verdrillt verdrillung verdrillgruppe; torsade torsadee; "
    "intrecciato; trenzado",
    _Kind.PLACE: "place placement",
    _Kind.FILLER: "no nr num number id identifier ident name tag code label mark the of in cross "
    "insulation cut dt full data info designation diameter complete est estimated "
    "total nominal run finished; daten angaben gesamt; donnees; dati; datos; nummer "
    "name bezeichnung nummern kennzeichen in isolations zuschnitt des der durchmesser "
    "ø einzel verlege vollstandig; numero nom n du des le la l d en coupe repere "
    "isolant; numero nome sigla numerazione marcatura del di in taglio isolante; "
    "numero nombre codigo marca del el en corte",
}
# Prepositions mean an end only beside nothing but a component or a terminal: "De borne", not
# "Section de fil". The letter is an end's name where another heading has a B.
_FROM_PREPOSITIONS = frozenset({"de", "da", "dal", "dalla"})
_TO_PREPOSITIONS = frozenset({"a", "al", "alla", "au"})
_ENDINGS = frozenset({"end", "ende", "fin", "fine", "extremite"})
_SIDES = frozenset({"side", "seite", "cote", "lato", "lado"})
_FILLERS = _FROM_PREPOSITIONS | _TO_PREPOSITIONS | _ENDINGS | _SIDES
_FIRST, _SECOND = frozenset({"1"}), frozenset({"2", "b"})
# What a harness has in a cavity, beside its pin; in a cabinet it is the terminal itself.
_CONTACTS = frozenset(
    {"terminal", "term", "contact", "kontakt", "contatto", "contacto", "terminale"}
)
# On machines that cut and crimp, the ends of a wire are its left and its right one.
_LEFT_AND_RIGHT = (
    "left right links linke linker linkes rechts rechte rechter rechtes gauche droite droit "
    "sinistra sinistro destra destro izquierda izquierdo derecha derecho"
)
_OF_MACHINES = frozenset(_LEFT_AND_RIGHT.split())
# Alone they are the number of a line, or say nothing of an end.
_LONE = frozenset({("item",), ("unit",), ("pos",), ("position",)})
_CONNECTIONS = frozenset({"connection", "circuit", "ckt"})
# In a cabinet, what such a word names is found by its component's tag: "X1:3". Pins are not.
_WHOLE_TERMINALS = frozenset(
    {"terminal", "klemme", "anschluss", "borne", "morsetto", "borna", "connection"}
    | {"point", "points"}
)
_BOTH = re.compile(r"\w\s*[/:+&]\s*\w")  # "Device/Pin"
_DIAMETERS = frozenset({"diameter", "durchmesser", "ø"})

_KINDS = {
    word: kind for kind, words in _WORDS.items() for word in words.replace(";", " ").split()
} | dict.fromkeys(_FILLERS, _Kind.FILLER)
# Words that mean something else together than each alone.
_PHRASES = {
    "connection point": "terminal",
    "anschlusspunkt": "klemme",
    "ref des": "refdes",
    "start point": "startpoint",
    "end point": "endpoint",
    "terminal strip": "terminalstrip",
    "terminal block": "terminalstrip",
    "wire ref": "wire",
    "cable ref": "cable",
    "gauge type": "gauge",
    "twist group": "twist",
    "twisted group": "twist",
}
_FIELDS = {
    (_Kind.FROM, None): Field.FROM,
    (_Kind.FROM, _Kind.COMPONENT): Field.FROM_COMPONENT,
    (_Kind.FROM, _Kind.TERMINAL): Field.FROM_TERMINAL,
    (_Kind.TO, None): Field.TO,
    (_Kind.TO, _Kind.COMPONENT): Field.TO_COMPONENT,
    (_Kind.TO, _Kind.TERMINAL): Field.TO_TERMINAL,
    (_Kind.FROM, _Kind.SEAL): Field.FROM_SEAL,
    (_Kind.TO, _Kind.SEAL): Field.TO_SEAL,
    (_Kind.FROM, _Kind.PLACE): Field.FROM_PLACE,
    (_Kind.TO, _Kind.PLACE): Field.TO_PLACE,
}
# Where a component has a column of its own, a column of the whole end says something else.
_COMPONENT_OF = {Field.FROM: Field.FROM_COMPONENT, Field.TO: Field.TO_COMPONENT}
_NAMES = frozenset(
    {"name", "id", "tag", "label", "bezeichnung", "kennzeichen", "nom", "repere", "nome", "sigla"}
    | {"nombre", "identifier", "ident", "numerazione", "marcatura", "marca"}
)
_NUMBERS = frozenset({"no", "nr", "num", "number", "nummer", "numero", "n", "codigo", "code"})
_QUANTITIES = {
    _Kind.COLOUR: Field.COLOUR,
    _Kind.SECTION: Field.SECTION,
    _Kind.LENGTH: Field.LENGTH,
}
# The innermost of several comes first: a "cable core" is a core.
_ARTICLE = frozenset({"pn", "p", "part", "type", "typ", "article", "artikel", "reference", "ref"})
_THINGS = {
    _Kind.TWISTED: Field.TWISTED,
    _Kind.CORE: Field.CORE,
    _Kind.WIRE: Field.WIRE,
    _Kind.CABLE: Field.CABLE,
}
_PARTS = (_Kind.TERMINAL, _Kind.COMPONENT)  # a "connector pin" is a pin

_SECTION_UNITS = {
    **dict.fromkeys(("mm²", "mm2", "mm^2", "qmm", "sqmm", "mmq", "mm sq", "sq mm"), "mm2"),
    "awg": "awg",
}
_LENGTH_UNITS = {
    **{unit: unit for unit in ("mm", "cm", "dm", "m", "in", "ft")},
    **{"inch": "in", "inches": "in", "zoll": "in", '"': "in", "feet": "ft"},
}
_UNITS = {**_SECTION_UNITS, **_LENGTH_UNITS}
_UNIT = re.compile(
    r"(?:^|[\s_,/(\[<-])\s*("
    + "|".join(sorted(map(re.escape, _UNITS), key=len, reverse=True))
    + r")\s*[)\]>]?\.?$",
    re.IGNORECASE,
)
_LEAST_PART = 3  # letters of a word in a compound, but for
_SHORT_PARTS = frozenset({"nr"})
_ABBREVIATION = re.compile(r"([^\W\d_]{3,})\.")
_SIMILAR = 0.75
_LENGTH_FIELDS = (Field.LENGTH, Field.FROM_X, Field.FROM_Y, Field.TO_X, Field.TO_Y)


def unit_in(heading: str, field: Field) -> str:
    """Return the unit that a field's heading states, such as mm of "Length (mm)"; empty if none."""
    match = _UNIT.search(_spaced(heading))
    unit = match[1].lower() if match else ""
    if field is Field.SECTION:
        return _SECTION_UNITS.get(unit, "")
    return _LENGTH_UNITS.get(unit, "") if field in _LENGTH_FIELDS else ""


def fields_of(headings: Sequence[str]) -> dict[Field, int]:
    """Return the number of each field's column, as far as the words of the headings name them.

    A component or a terminal without an end belongs to the end of the heading before it, or, of two
    such headings, the first to the one and the second to the other end. Of several columns that
    mean the same the first is taken; a mere "No" or "Name" is a wire's if nothing else is, and so
    are the core of a list without cables, and a signal.
    """
    words = _apart([_words(_without_unit(heading)) for heading in headings])
    has_b = any("b" in each for each in words)
    readings = [_reading(each, has_b=has_b) for each in words]
    readings = [
        (side, None if _names_both(heading, each) else part)
        for heading, each, (side, part) in zip(headings, words, readings, strict=True)
    ]
    found: dict[Field, int] = {}
    end: _Kind | None = None
    undirected = [
        i
        for i, (side, part) in enumerate(readings)
        if not side and part in _PARTS and (words[i] not in _LONE or words.count(words[i]) == 2)
    ]
    for column, (side, part) in enumerate(readings):
        end = side or end
        field = _unit_field(headings[column], words[column])
        if field is None and side is None and part in _PARTS:
            alike = [i for i in undirected if readings[i][1] is part]
            if len(alike) == 2 and column in alike:
                before = (_Kind.FROM, _Kind.TO)[alike.index(column)]
                field = _FIELDS[end or before, part]
        elif field is None and side is not None:
            field = _FIELDS.get((side, part))
        elif field is None and part is not None:
            field = {**_QUANTITIES, **_THINGS, _Kind.PLACE: Field.PLACE}.get(part)
        if field in found and not _is_weak(words[column]) and _is_weak(words[found[field]]):
            found[field] = column
        elif field is not None:
            found.setdefault(field, column)
    found |= _single_end(found, [(part, i) for i in undirected if (part := readings[i][1])])
    names = [i for names in (_NAMES, _NUMBERS) for i, each in enumerate(words) if names >= {*each}]
    name = next((i for i in names if words[i] and i not in found.values()), None)
    if Field.WIRE not in found and name is None and Field.CABLE not in found:
        name = found.pop(Field.CORE, None)  # "Ader" is both
    signals = (i for i, each in enumerate(words) if _names_signal(each))
    name = next(signals, None) if name is None else name
    if Field.WIRE not in found and name is not None:
        found[Field.WIRE] = name
    found = _with_whole_terminals(found, words)
    if Field.COMPONENT in found and Field.WIRE not in found:
        own = next((field for field in (Field.CORE, Field.CABLE) if field in found), None)
        found |= {Field.WIRE: found.pop(own)} if own else {}
    if Field.COMPONENT not in found:
        found.pop(Field.PLACE, None)  # of which end is not said
    return {f: i for f, i in found.items() if _COMPONENT_OF.get(f) not in found}


def _single_end(
    found: Mapping[Field, int], undirected: Sequence[tuple[_Kind, int]]
) -> dict[Field, int]:
    """Return the columns of a list with a line for each end, where no heading names an end."""
    columns = dict(undirected)
    is_single = len(undirected) == len(_PARTS) and columns.keys() == {*_PARTS}
    if not is_single or not {*_FIELDS.values()}.isdisjoint(found):
        return {}
    return {
        Field.COMPONENT: columns[_Kind.COMPONENT],
        Field.TERMINAL: columns[_Kind.TERMINAL],
    }


def _with_whole_terminals(
    found: dict[Field, int], words: Sequence[Sequence[str]]
) -> dict[Field, int]:
    """Return the columns, with terminals as whole ends if no column is of a component."""
    ends = ((Field.FROM_TERMINAL, Field.FROM), (Field.TO_TERMINAL, Field.TO))
    others = {Field.FROM, Field.FROM_COMPONENT, Field.TO, Field.TO_COMPONENT}
    is_whole = others.isdisjoint(found) and all(
        terminal in found and not _WHOLE_TERMINALS.isdisjoint(words[found[terminal]])
        for terminal, _ in ends
    )
    wholes = dict(ends) if is_whole else {}
    return {wholes.get(field, field): column for field, column in found.items()}


def _names_both(heading: str, words: Sequence[str]) -> bool:
    """Return whether a heading is about a component and its terminal, such as "Device/Pin"."""
    return {*_PARTS} <= (_kinds(words) or set()) and _BOTH.search(heading) is not None


def _names_signal(words: Sequence[str]) -> bool:
    kinds = _kinds(words) or set()
    return _Kind.SIGNAL in kinds and kinds <= {_Kind.SIGNAL, _Kind.FILLER}


def is_unit(text: str) -> bool:
    """Return whether a text is the unit of a section or a length, with or without brackets."""
    return text.strip("[]()<> ").lower() in _UNITS


def has_meaning(text: str) -> bool:
    """Return whether a text has no words but those of headings, or names a unit."""
    words = _words(_without_unit(text))
    return _kinds(words) is not None if words else is_unit(text)


def names_contact(heading: str) -> bool:
    """Return whether a heading may be about a wire end's contact rather than a cavity or a pin."""
    return _is_contact(_words(_without_unit(heading)))


def _is_contact(words: Sequence[str]) -> bool:
    parts = {word for word in words if _KINDS.get(word) is _Kind.TERMINAL}
    return bool(parts) and parts <= _CONTACTS


def _is_weak(words: Sequence[str]) -> bool:
    """Return whether a heading gives way to another one of the same field."""
    return _is_contact(words) or "termination" in words


def _apart(words: list[tuple[str, ...]]) -> list[tuple[str, ...]]:
    """Return the words of headings, without a side that all of them have, such as "Ziel 1, Ziel 2".

    The number separates the ends then.
    """
    sides = {
        (_KINDS[word], number)
        for each in words
        for word in each
        if _KINDS.get(word) in (_Kind.FROM, _Kind.TO)
        for number in {*each} & {"1", "2"} or {""}
    }
    kinds = {kind for kind, _ in sides}
    if len(kinds) != 1 or {number for _, number in sides} != {"1", "2"}:
        return words
    return [tuple("component" if _KINDS.get(w) in kinds else w for w in each) for each in words]


def similar_heading(heading: str) -> str:
    """Return what a heading that is not known may be misspelt for; empty if it is like nothing."""
    words = _plain(_without_unit(heading)).split()
    nearer = []
    for word in words:
        near = [word] if _kinds([word]) else get_close_matches(word, _KINDS, 1, _SIMILAR)
        if not near:
            return ""
        nearer.append(near[0])
    return " ".join(nearer) if nearer != words else ""


def _unit_field(heading: str, words: Sequence[str]) -> Field | None:
    """Return the field that a unit names: "AWG", "Wire mm²" or "L [mm]"; None if none."""
    match = _UNIT.search(_spaced(heading))
    if match is not None and words == ("l",) and match[1].lower() in _LENGTH_UNITS:
        return Field.LENGTH
    if match is None or match[1].lower() not in _SECTION_UNITS:
        return None
    kinds = _kinds(words)
    return Field.SECTION if kinds is not None and kinds <= {_Kind.FILLER, *_THINGS} else None


def _reading(words: Sequence[str], *, has_b: bool) -> tuple[_Kind | None, _Kind | None]:
    """Return which end a heading is about, and what of it; None for what it does not say."""
    number = {*words} & {"1", "2", "a", "b"}
    for kind in (_Kind.SEAL, _Kind.PLACE):
        if any(_KINDS.get(word) is kind for word in words):
            return _reading_beside(kind, words, has_b=has_b)
    kinds = _kinds([word for word in words if word not in number])
    if kinds is None or (not _DIAMETERS.isdisjoint(words) and _Kind.SECTION not in kinds):
        return None, None
    if words == ("termination",):
        return _Kind.TO, None
    sides = kinds & {_Kind.FROM, _Kind.TO}
    rest = kinds - sides - {_Kind.FILLER}
    quantities = rest & _QUANTITIES.keys()
    if quantities:
        is_of_wire = len(quantities) == 1 and not sides and rest - quantities <= _THINGS.keys()
        return None, quantities.pop() if is_of_wire and not number & {"1", "2", "b"} else None
    names_end = bool(sides) or not _ENDINGS.isdisjoint(words)
    if names_end and _Kind.WIRE in rest and not _CONNECTIONS.isdisjoint(words):
        rest = rest - {_Kind.WIRE} | {_Kind.TERMINAL}
    part = next((kind for kind in _PARTS if kind in rest), None)
    if part is _Kind.TERMINAL and _is_contact(words) and not _OF_MACHINES.isdisjoint(words):
        return None, None
    if not rest <= {*_PARTS}:
        thing = next((kind for kind in _THINGS if kind in rest), None)
        return None, thing if rest <= _THINGS.keys() and not sides else None
    if len(sides) > 1 or (part is None and not _SIDES.isdisjoint(words)):
        return None, None
    return (sides.pop() if sides else _weak_side(words, part, has_b=has_b)), part


def _reading_beside(
    kind: _Kind, words: Sequence[str], *, has_b: bool
) -> tuple[_Kind | None, _Kind | None]:
    """Return the end of a heading about a seal or a place, also of a cavity or a component."""
    left = [word for word in words if word not in _ARTICLE and word not in {"1", "2", "a", "b"}]
    kinds = _kinds(left)
    if kinds is None or not kinds <= {kind, _Kind.FROM, _Kind.TO, _Kind.FILLER, *_PARTS}:
        return None, None
    sides = kinds & {_Kind.FROM, _Kind.TO}
    side = sides.pop() if len(sides) == 1 else _weak_side(words, kind, has_b=has_b)
    return side, kind


def _weak_side(words: Sequence[str], part: _Kind | None, *, has_b: bool) -> _Kind | None:
    """Return the end that a number, a letter or a preposition names."""
    given = {*words}
    has_part = part is not None or not _ENDINGS.isdisjoint(given)
    if has_part and (given & _FIRST or (has_b and "a" in given)):
        return _Kind.FROM
    if has_part and given & _SECOND:
        return _Kind.TO
    only = len(words) == 1
    if words and words[0] in _FROM_PREPOSITIONS and (has_part or only):
        return _Kind.FROM
    if words and words[0] in _TO_PREPOSITIONS and not has_b and (has_part or only):
        return _Kind.TO
    return _Kind.TO if given & _ENDINGS and (has_part or only) else None


def _kinds(words: Sequence[str]) -> set[_Kind] | None:
    """Return what words stand for, or None if one is not known."""
    kinds = {_KINDS.get(word) for word in words}
    return None if None in kinds else {kind for kind in kinds if kind is not None}


def _without_unit(heading: str) -> str:
    return _UNIT.sub("", _spaced(heading))


def _spaced(heading: str) -> str:
    """Return a heading with the words of "LengthMM" apart."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", heading.strip())


@lru_cache(10_000)
def _words(text: str) -> tuple[str, ...]:
    plain = f" {_plain(_ABBREVIATION.sub(_in_full, text))} "
    for phrase, word in _PHRASES.items():
        plain = plain.replace(f" {phrase} ", f" {word} ")
    return tuple(part for word in plain.split() for part in _parts(word))


def _in_full(abbreviation: re.Match[str]) -> str:
    """Return a word that begins like an abbreviation, if all of them have the same meaning."""
    start = _plain(abbreviation[1])
    if start in _KINDS:
        return f"{start} "
    words = [word for word in _KINDS if word.startswith(start)]
    alike = len({_KINDS[word] for word in words}) == 1
    return f"{min(words, key=len)} " if alike else abbreviation[0]


def _plain(text: str) -> str:
    """Return the words of a text in lower case, without accents and signs."""
    text = _spaced(text)
    text = re.sub("[\u00b0\u00ba\u00aa]", " ", text).replace("#", " no ")
    text = unicodedata.normalize("NFKD", text).lower()
    text = "".join(sign for sign in text if not unicodedata.combining(sign))
    return " ".join(re.findall(r"[^\W\d_]+|\d+", text))


@cache
def _parts(word: str) -> tuple[str, ...]:
    """Return the listed words that make up a compound; the word itself if there are none."""
    if word in _KINDS:
        return (word,)
    for length in range(len(word) - 2, _LEAST_PART - 1, -1):
        if word[:length] in _KINDS:
            rest = _parts(word[length:])
            is_long = len(word) - length >= _LEAST_PART or word[length:] in _SHORT_PARTS
            if is_long and all(part in _KINDS for part in rest):
                return (word[:length], *rest)
    return (word,)
