"""Messages as the "name=value" texts of an ability record."""

from __future__ import annotations

from genpy import Message
from geometry_msgs.msg import PoseStamped


def described(message: Message, left_out: frozenset[str]) -> list[str]:
    """Return the numbers, truth values, texts and poses of a message as "name=value"."""
    fields = {name: getattr(message, name) for name in message.__slots__ if name not in left_out}
    texts = {name: _text(value) for name, value in fields.items()}
    return [f"{name}={text}" for name, text in texts.items() if text is not None]


def _text(value: object) -> str | None:
    """Return a value as text; None if it is neither plain nor a pose, or several."""
    if isinstance(value, bool | int | float | str):
        return str(value)
    if isinstance(value, PoseStamped):
        position, turn = value.pose.position, value.pose.orientation
        numbers = (position.x, position.y, position.z, turn.x, turn.y, turn.z, turn.w)
        return " ".join(
            [value.header.frame_id or "-", *(f"{round(n, 6) + 0.0:g}" for n in numbers)]
        )
    if isinstance(value, list) and value and all(isinstance(item, PoseStamped) for item in value):
        return "; ".join(str(_text(item)) for item in value)
    return None
