"""The list of abilities in the README of remodel_states."""

import re
from collections.abc import Iterable

from remodel_states.core.tables import Ability

_REGION = re.compile(
    r"(?<=<!-- drawn by make generate -->\n).*?(?=<!-- end of what is drawn -->)", re.DOTALL
)


def with_ability_list(page: str, abilities: Iterable[Ability]) -> str:
    """Return the page with the list of these abilities in its marked region."""
    rows = "".join(_row(ability) for ability in abilities)
    head = "| ability | what it does | outcome of its state |\n|---|---|---|\n"
    text = f"\n{head}{rows}\n"
    return _REGION.sub(lambda _: text, page)


def _row(ability: Ability) -> str:
    outcome = f"`{ability.state.outcome}`" if ability.state else "-"
    return f"| `{ability.name}` | {ability.action.title} | {outcome} |\n"
