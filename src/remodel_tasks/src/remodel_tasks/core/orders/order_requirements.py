"""What preferences require of an order's tasks before they are planned.

Two entries of `require` (preferences.py has the others):

    {name: TEXT, by_hand: NAMES}            # no robot does these tasks
    {name: TEXT, begin: NAMES, at: a|b}     # which end of these wires is inserted first
    NAMES: the name of a task, or a list of names
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from remodel_production.errors import OrderError
from remodel_tasks.core.problem.fields import Fields
from remodel_tasks.core.problem.instance import end_from
from remodel_tasks.core.problem.preferences import document_fields, requirements
from remodel_tasks.core.problem.problem import End

_OWN = ("by_hand", "begin")


@dataclass(frozen=True)
class OrderRequirements:
    """What is required of single tasks.

    Attributes:
        by_hand: names of tasks, with the names of the requirements.
        first: names of tasks, with the ends that are inserted first.
    """

    by_hand: tuple[tuple[str, str], ...] = ()
    first: tuple[tuple[str, End], ...] = ()

    def require_known(self, names: Iterable[str], order: str) -> None:
        """Raise OrderError if a requirement is about a task that the order does not have."""
        if lost := sorted({*dict(self.by_hand), *dict(self.first)}.difference(names)):
            raise OrderError(
                f"order {order}: its preferences require something of {lost[0]}, which is no task "
                "of it; correct `by_hand` and `begin` under `require`"
            )


NOTHING_REQUIRED = OrderRequirements()


def order_requirements(documents: Iterable[object]) -> OrderRequirements:
    """Return what parsed documents of preferences require of single tasks.

    Raises:
        InstanceError: naming the entry that is malformed.
    """
    by_hand: dict[str, str] = {}
    first: dict[str, End] = {}
    for document in documents:
        for item in requirements(document_fields(document)):
            if item.has("by_hand"):
                item.only("name", "by_hand")
                by_hand |= dict.fromkeys(_names(item, "by_hand"), item.text("name"))
            elif item.has("begin"):
                item.only("name", "begin", "at")
                first |= dict.fromkeys(_names(item, "begin"), end_from(item, "at"))
    return OrderRequirements(tuple(by_hand.items()), tuple(first.items()))


def required_by(preferences: object) -> OrderRequirements:
    """Return what an order's preferences require; nothing if it has none (None)."""
    return order_requirements([] if preferences is None else [preferences])


def of_plans(document: object) -> object:
    """Return a document of preferences without the entries of this module."""
    if not isinstance(document, Mapping) or not isinstance(document.get("require"), list):
        return document
    kept = [each for each in document["require"] if not _is_own(each)]
    return {**document, "require": kept}


def _is_own(entry: object) -> bool:
    return isinstance(entry, Mapping) and any(key in entry for key in _OWN)


def _names(item: Fields, key: str) -> tuple[str, ...]:
    return item.texts(key) if isinstance(item.value(key), list) else (item.text(key),)
