"""Which abilities a node serves, of those that there are."""

from __future__ import annotations

from collections.abc import Collection


def chosen_abilities(
    known: Collection[str], abilities: object = "", others: object = ""
) -> list[str]:
    """Return the abilities to serve, in the order of `known`.

    Args:
        known: names of all abilities.
        abilities: those to serve, a list or text such as "InsertCable, PickCable"; empty text: all,
            empty list: none.
        others: those of them not to serve, in the same form.

    Raises:
        ValueError: if a name is none of `known`.
    """
    wanted = list(known) if abilities == "" else _names("abilities", abilities, known)
    without = _names("except", others, known)
    return [name for name in known if name in wanted and name not in without]


def _names(parameter: str, value: object, known: Collection[str]) -> list[str]:
    if isinstance(value, str):
        names = [name.strip() for name in value.split(",") if name.strip()]
    elif isinstance(value, list | tuple):
        names = [str(name) for name in value]
    else:
        raise ValueError(
            f"parameter {parameter!r} is {value!r}; allowed: names of abilities, "
            "separated by commas"
        )
    if unknown := sorted(set(names) - set(known)):
        raise ValueError(
            f"parameter {parameter!r} names no ability: {', '.join(unknown)}; "
            f"there are {', '.join(known)}"
        )
    return names
