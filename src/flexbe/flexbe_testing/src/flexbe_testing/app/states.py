"""State definition files, as the App reads them."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from flexbe_testing.app import text as cut

_CLASS = re.compile(r"^\s*class\s+(\w+)\s*\(EventState\)\s*:", re.MULTILINE)
_PARAMETERS = re.compile(r"\bdef __init__\(self, ([^)\n]+)\):")
_LISTS = ("outcomes", "input_keys", "output_keys")


@dataclass(frozen=True)
class FromParameter:
    """A list of names that comes from the value of a parameter; a `?` begins an artificial one."""

    parameter: str


Names = tuple[str, ...] | FromParameter


@dataclass(frozen=True)
class StateDefinition:
    """What the App knows of a state class.

    Attributes:
        module: where behaviors import it from.
        parameters: default of each parameter as text; None if it has none.
        outcomes: without blanks, which the App drops.
        spellings: each outcome as the file spells it, by the App's name of it.
    """

    class_name: str
    package: str
    module: str
    parameters: dict[str, str | None]
    outcomes: Names = ()
    input_keys: Names = ()
    output_keys: Names = ()
    spellings: dict[str, str] = field(default_factory=dict)


def read_state(text: str, module: str) -> StateDefinition | None:
    """Return the first state of a file, None if the App sees none."""
    found = _CLASS.search(text)
    if found is None:
        return None
    body = text[found.end() :]
    given = _PARAMETERS.search(body)
    parameters = dict(map(_parameter, cut.items(given[1]))) if given else {}
    lists: dict[str, Names] = {}
    spellings: dict[str, str] = {}
    for keyword, value in _super_arguments(body).items():
        if keyword in _LISTS:
            lists[keyword] = _names(keyword, value, parameters)
            if keyword == "outcomes":
                spellings = {without_blanks(name): name for name in cut.names(value) or ()}
    parameters |= {
        listed.parameter: None
        for listed in lists.values()
        if isinstance(listed, FromParameter) and listed.parameter not in parameters
    }
    package = module.partition(".")[0]
    return StateDefinition(found[1], package, module, parameters, spellings=spellings, **lists)


def without_blanks(outcome: str) -> str:
    """Return an outcome as the App reads it from a list of outcomes."""
    return re.sub(r"\s", "", outcome)


def _parameter(text: str) -> tuple[str, str | None]:
    """Return name and default; an annotation counts as part of the name, as in the App."""
    name, equals, default = text.partition("=")
    return name.strip(), re.sub(r"\s", "", default) if equals else None


def _super_arguments(body: str) -> dict[str, str]:
    call = re.search(r"\bsuper\([^)]*\)\.__init__\(", body)
    inner = call and cut.bracketed(body, call.end() - 1)
    return dict(_keyword(item) for item in cut.items(inner or "") if "=" in item)


def _keyword(item: str) -> tuple[str, str]:
    name, _, value = item.partition("=")
    return name.strip(), value.strip()


def _names(keyword: str, value: str, parameters: dict[str, str | None]) -> Names:
    listed = cut.names(value)
    if listed is not None:
        return tuple(without_blanks(n) if keyword == "outcomes" else n for n in listed)
    return FromParameter(value if value in parameters else f"?{keyword}")
