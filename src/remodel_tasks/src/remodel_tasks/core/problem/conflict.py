"""Which requirements contradict each other: a smallest set of those that no plan keeps.

QuickXplain (Junker, AAAI 2004) halves the requirements and asks which half is needed beside the
other one. A set that it returns has no part that is not needed: with any one of it dropped, the
rest of the set can be kept. Of several such sets it returns one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

_Required = TypeVar("_Required")
Documents = Sequence[tuple[str, object]]


@dataclass(frozen=True)
class Requirement:
    """An entry under `require` of a preferences document.

    Attributes:
        document: its number.
        index: of the entry in its document.
        source: name of the document.
    """

    document: int
    index: int
    source: str
    entry: Mapping[str, object]

    @property
    def name(self) -> str:
        """The user's name for it."""
        return str(self.entry.get("name", "without a name"))

    def __str__(self) -> str:
        """Return the line for a person."""
        fields = ", ".join(f"{key}: {value}" for key, value in self.entry.items() if key != "name")
        return f"`{self.name}` ({self.source}, require[{self.index}]): {fields}"


def requirements_in(documents: Documents) -> list[Requirement]:
    """Return the requirements of documents, as far as the documents have the form for it."""
    found = []
    for number, (source, document) in enumerate(documents):
        entries = document.get("require") if isinstance(document, Mapping) else None
        for index, entry in enumerate(entries if isinstance(entries, list) else []):
            if isinstance(entry, Mapping):
                found.append(Requirement(number, index, source, entry))
    return found


def keeping(documents: Documents, kept: Sequence[Requirement]) -> list[tuple[str, object]]:
    """Return documents with no requirements but those."""
    left = {(each.document, each.index) for each in kept}
    result: list[tuple[str, object]] = []
    for number, (source, document) in enumerate(documents):
        entries = document.get("require") if isinstance(document, Mapping) else None
        if isinstance(document, Mapping) and isinstance(entries, list):
            some = [entry for i, entry in enumerate(entries) if (number, i) in left]
            document = {**document, "require": some}
        result.append((source, document))
    return result


def conflicts_of(
    requirements: Sequence[_Required], has_plan: Callable[[Sequence[_Required]], bool]
) -> list[list[_Required]]:
    """Return smallest conflicts that share no requirement; a plan keeps what is in none of them."""
    found: list[list[_Required]] = []
    left = list(requirements)
    while conflict := smallest_conflict(left, has_plan):
        found.append(conflict)
        left = [each for each in left if each not in conflict]
    return found


def smallest_conflict(
    requirements: Sequence[_Required], has_plan: Callable[[Sequence[_Required]], bool]
) -> list[_Required]:
    """Return a smallest set of requirements that no plan keeps; empty if there is none.

    Args:
        requirements: those preferred to be kept come first.
        has_plan: whether there is a plan with some of them. There is none with more than a set that
            has none. If there is none without any of them, the set is empty, too.
    """
    if has_plan(requirements) or not has_plan(()):
        return []

    def needed(
        kept: list[_Required], candidates: list[_Required], *, has_grown: bool
    ) -> list[_Required]:
        if has_grown and not has_plan(kept):
            return []
        if len(candidates) == 1:
            return candidates
        middle = len(candidates) // 2
        first, second = candidates[:middle], candidates[middle:]
        of_second = needed([*kept, *first], second, has_grown=True)
        of_first = needed([*kept, *of_second], first, has_grown=bool(of_second))
        return [*of_first, *of_second]

    return needed([], list(requirements), has_grown=False)
