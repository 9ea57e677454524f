"""In which circumstances an ability was called."""

from __future__ import annotations

from remodel_planner.core.condition import Features

# An ability, then "feature=value", the most general first.
Context = tuple[str, ...]

# Of a task's features, those that abilities may depend on, the most general first: type of the
# connector or terminal, gauge, direction of approach, view.
_FEATURES = ("terminal_type", "section_mm2", "approach", "view")


def context_of(ability: str, features: Features) -> Context:
    """Return the context of a call; features that are not known are left out."""
    known = [(name, features[name]) for name in _FEATURES if name in features]
    return (ability, *(f"{name}={_text(value)}" for name, value in known))


def _text(value: str | float | bool) -> str:
    return f"{value:g}" if isinstance(value, float | int) else value
