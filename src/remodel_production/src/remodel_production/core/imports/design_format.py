"""A format of design files, and which modules and variants of a harness are read.

KBL writes conditions as Logistic_control_information, VEC as LogisticControlString or
LogisticControlExpression. Their syntax is each company's own; what most of them share is read:

    condition = term, {or, term}      or:  /  |  ||  OR  ODER
    term      = factor, {and, factor} and: +  &  &&  AND  UND
    factor    = [not], (code | "(", condition, ")")      not:  -  !  ~  NOT  NICHT

A `;` may end it. Whether + or / binds stronger differs between companies, so that a condition with
both of them side by side needs brackets.

A harness file describes all variants at once (150 %). A module lists its parts, and may have a
condition of variant codes; so may a part itself. What no module lists is in every variant.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from lxml import etree

from remodel_production.core.catalogue import Catalogue
from remodel_production.core.imports.documents import decode, local_name, parse_xml
from remodel_production.core.imports.values import Imported
from remodel_production.errors import DesignError
from remodel_run.whole_task import counted

_TOKEN = re.compile(r"\s*(?:([^\W_][\w.:%#]*|_[\w.:%#]*)|(&&|\|\||[-+&/|!~()\u00ac]))")
_AND = frozenset({"+", "&", "&&", "AND", "UND"})
_OR = frozenset({"/", "|", "||", "OR", "ODER"})
_NOT = frozenset({"-", "!", "~", "\u00ac", "NOT", "NICHT"})
_AMBIGUOUS = frozenset({"+", "/"})

_Test = Callable[[Collection[str]], bool]


@dataclass(frozen=True)
class VariantCondition:
    """A condition, as it is written and where."""

    text: str
    where: str

    def holds(self, codes: Collection[str]) -> bool:
        """Return whether it holds for a vehicle with these codes and no others.

        Raises:
            DesignError: if it cannot be read.
        """
        return _Parser(self).test(codes)

    def codes(self) -> frozenset[str]:
        """Return the codes that it names; DesignError if it cannot be read."""
        return frozenset(_Parser(self).codes)


class _Parser:
    def __init__(self, condition: VariantCondition) -> None:
        self._condition = condition
        self._left = list(self._tokens(condition.text.strip().removesuffix(";").rstrip()))
        self.codes: set[str] = set()
        self.test = self._any()
        if self._left:
            raise self._refused(f"{self._left[0]!r} is not expected there")

    def _tokens(self, text: str) -> list[str]:
        tokens, at = [], 0
        while at < len(text):
            match = _TOKEN.match(text, at)
            if match is None:
                raise self._refused(f"{text[at:].split()[0]!r} is not known")
            tokens.append(match[1] or match[2])
            at = match.end()
        return tokens

    def _next_of(self, words: Collection[str]) -> str:
        """Take the next token if it is one of some words; return it, or an empty one."""
        if self._left and self._left[0].upper() in words:
            return self._left.pop(0).upper()
        return ""

    def _any(self) -> _Test:
        signs: set[str] = set()
        terms = [self._all(signs)]
        while sign := self._next_of(_OR):
            signs.add(sign)
            terms.append(self._all(signs))
        if signs >= _AMBIGUOUS:
            raise self._refused(
                "whether + or / binds stronger differs between companies: put brackets around one"
            )
        return lambda codes: any(term(codes) for term in terms)

    def _all(self, signs: set[str]) -> _Test:
        factors = [self._factor()]
        while sign := self._next_of(_AND):
            signs.add(sign)
            factors.append(self._factor())
        return lambda codes: all(factor(codes) for factor in factors)

    def _factor(self) -> _Test:
        if self._next_of(_NOT):
            factor = self._factor()
            return lambda codes: not factor(codes)
        if self._next_of("("):
            inner = self._any()
            if not self._next_of(")"):
                raise self._refused("a bracket is not closed")
            return inner
        if not self._left or not (code := self._left.pop(0))[0].isalnum():
            raise self._refused("a code is missing")
        self.codes.add(code)
        return lambda codes: code in codes

    def _refused(self, why: str) -> DesignError:
        return DesignError(
            f"{self._condition.where}: variant condition {self._condition.text!r} cannot be read: "
            f"{why}; import without --variant, or choose by --module"
        )


_SHOWN = 20


@dataclass(frozen=True)
class Asked:
    """What is asked for; all is read if nothing is.

    Attributes:
        modules: part numbers of modules, or of what consists of modules.
        codes: variant codes that the vehicle has; an empty one stands for none.
    """

    modules: tuple[str, ...] = ()
    codes: tuple[str, ...] = ()


ALL = Asked()


@dataclass(frozen=True)
class Composite:
    """A part that lists other parts.

    Attributes:
        is_module: whether its parts are in some variants only.
        condition: of the variants that it is in; None: it is asked for by its name alone.
    """

    parts: frozenset[etree._Element]
    is_module: bool
    condition: VariantCondition | None = None


class ModuleChoice:
    """The parts that are chosen."""

    def __init__(
        self,
        composites: Mapping[str, Composite],
        conditions: Mapping[etree._Element, VariantCondition],
        asked: Asked,
    ) -> None:
        """Choose what is asked for of composites, by part number; conditions are of single parts.

        Raises:
            DesignError: if there is no such part or code, or a condition cannot be read.
        """
        _require_known("module or harness configuration", asked.modules, composites, "--module")
        self._conditions = conditions
        self._codes = asked.codes
        modules = {name: each for name, each in composites.items() if each.is_module}
        written = [*conditions.values(), *(m.condition for m in modules.values() if m.condition)]
        if asked.codes:
            known = sorted({code for condition in written for code in condition.codes()})
            codes = [code for code in asked.codes if code]
            _require_known("variant code", codes, known, "--variant")
        chosen = [composites[name] for name in asked.modules]
        if asked.codes and not asked.modules:
            chosen = [
                module
                for module in modules.values()
                if module.condition is None or module.condition.holds(asked.codes)
            ]
        present = _parts(chosen)
        self._absent = _parts(modules.values()) - present if asked != ALL else frozenset()
        self.notes = tuple(_notes(asked, [*composites], len(modules), len(written)))

    def why_not(self, *parts: etree._Element | None) -> str:
        """Return why a wire with these parts is not chosen; empty if it is."""
        if any(part in self._absent for part in parts):
            return "its wire is in none of the modules asked for"
        for part in parts if self._codes else ():
            condition = self._conditions.get(part) if part is not None else None
            if condition is not None and not condition.holds(self._codes):
                return f"its variant {condition.text} is not asked for"
        return ""


def _parts(composites: Collection[Composite]) -> frozenset[etree._Element]:
    return frozenset[etree._Element]().union(*(composite.parts for composite in composites))


def _require_known(what: str, asked: Collection[str], known: Collection[str], option: str) -> None:
    unknown = [name for name in asked if name not in known]
    if unknown:
        advice = f"; there are {_shown(known)}: give one of them to" if known else ": omit"
        raise DesignError(f"the file has no {what} {unknown[0]}{advice} {option}")


def _notes(asked: Asked, names: list[str], modules: int, conditions: int) -> list[str]:
    notes = []
    if asked.modules:
        notes.append(f"the wires of modules {', '.join(sorted(asked.modules))} are read")
    elif modules > 1 and not asked.codes:
        notes.append(
            f"the parts of all {modules} modules are read, as of one harness; --module chooses of "
            f"{_shown(names)}"
        )
    if asked.codes:
        codes = ", ".join(filter(None, asked.codes)) or "none"
        notes.append(f"the wires of a vehicle with the variant codes {codes} are read")
    elif conditions:
        notes.append(
            "the parts of all variants are read, as of one harness, without regard to "
            f"{counted(conditions, 'condition')} of variant codes; --variant gives the codes of "
            "one vehicle"
        )
    return notes


def _shown(names: Collection[str]) -> str:
    return ", ".join([*names][:_SHOWN]) + (", ..." if len(names) > _SHOWN else "")


_NAME = re.compile(r"[a-z][a-z0-9_-]*")
_BEFORE_MARKUP = "\N{ZERO WIDTH NO-BREAK SPACE} \t\r\n"


@dataclass(frozen=True)
class DesignFile:
    """The content of a design file, by which formats recognise it."""

    data: bytes

    @cached_property
    def text(self) -> str:
        """The decoded content; empty if it is no text."""
        try:
            return decode(self.data)[0]
        except DesignError:
            return ""

    @cached_property
    def xml_root(self) -> str:
        """The local name of the XML root element; empty if the content is no XML."""
        try:
            return local_name(parse_xml(self.data)) if self.is_markup else ""
        except DesignError:
            return ""

    @property
    def is_markup(self) -> bool:
        """Whether the text begins as XML does."""
        return self.text.lstrip(_BEFORE_MARKUP).startswith("<")


@dataclass(frozen=True)
class JoinedFile:
    """A design file after others, as one content; `parts` says which of its lines are whose."""

    data: bytes
    parts: str


ReadModules = Callable[[bytes, str, str, Catalogue, Asked], Imported]
Join = Callable[[Sequence[tuple[str, bytes]], bytes], JoinedFile]


@dataclass(frozen=True)
class DesignFormat:
    """A format of design files.

    Attributes:
        name: the word of the command line: lower-case letters, digits, `_` and `-`.
        title: what its files are, in the plural, for messages.
        fits: whether a file has this format. It judges by the content, and raises nothing.
        read: reads the content of a file as an order with a name. Its other arguments are the name
            of the file and the catalogue of what the file leaves open. It raises DesignError, with
            the place, what was found and what is needed, if the file is refused.
        read_modules: the same with the modules and variant codes that are imported; None: files of
            this format have no modules.
        join: puts a file after others, each with its name and content; None: files of this format
            stand alone. It raises DesignError.

    Raises:
        DesignError: if the name cannot be a word of the command line.
    """

    name: str
    title: str
    fits: Callable[[DesignFile], bool]
    read: Callable[[bytes, str, str, Catalogue], Imported]
    read_modules: ReadModules | None = None
    join: Join | None = None

    def __post_init__(self) -> None:
        if not _NAME.fullmatch(self.name):
            raise DesignError(
                f"name of a design format: {self.name!r} found; needed: lower-case letters, "
                "digits, '_' and '-', a letter first"
            )
