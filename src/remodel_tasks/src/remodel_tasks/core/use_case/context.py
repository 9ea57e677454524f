"""In which circumstances an ability was called."""

from __future__ import annotations

from collections.abc import Sequence

from remodel_tasks.core.condition import Features, Value

# An ability, then "feature=value", the most general first.
Context = tuple[str, ...]

# Of a task's features, those that abilities may depend on, the most general first: type of the
# connector or terminal, gauge, direction of approach, view.
_FEATURES = ("terminal_type", "section_mm2", "approach", "view")


def context_of(ability: str, features: Features) -> Context:
    """Return the context of a call; features that are not known are left out."""
    known = [(name, features[name]) for name in _FEATURES if name in features]
    return (ability, *(f"{name}={_text(value)}" for name, value in known))


def terminal_features(kind: str, approach: Sequence[float] | None) -> dict[str, Value]:
    """Return the features of a terminal, as far as they are known.

    Args:
        kind: its type; empty if it is not known.
        approach: unit vector along which an end goes in, component's frame.
    """
    features: dict[str, Value] = {"terminal_type": kind} if kind else {}
    if approach is not None:
        features["approach"] = " ".join(f"{round(part, 1) + 0.0:g}" for part in approach)
    return features


def _text(value: str | float | bool) -> str:
    return f"{value:g}" if isinstance(value, float | int) else value
