"""Conditions of variants: which codes of a vehicle an element of a harness is for.

KBL writes them as Logistic_control_information, VEC as LogisticControlString or
LogisticControlExpression. Their syntax is each company's own; what most of them share is read:

    condition = term, {or, term}      or:  /  |  ||  OR  ODER
    term      = factor, {and, factor} and: +  &  &&  AND  UND
    factor    = [not], (code | "(", condition, ")")      not:  -  !  ~  NOT  NICHT

A `;` may end it. Whether + or / binds stronger differs between companies, so that a condition with
both of them side by side needs brackets.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection
from dataclasses import dataclass

from remodel_production.errors import DesignError

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
        return self._parsed().test(codes)

    def codes(self) -> frozenset[str]:
        """Return the codes that it names.

        Raises:
            DesignError: if it cannot be read.
        """
        return frozenset(self._parsed().codes)

    def _parsed(self) -> _Parser:
        parser = _Parser(self)
        parser.parse()
        return parser


class _Parser:
    def __init__(self, condition: VariantCondition) -> None:
        self._condition = condition
        self._left = list(self._tokens(condition.text.strip().removesuffix(";").rstrip()))
        self.codes: set[str] = set()
        self.test: _Test = bool

    def parse(self) -> None:
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
