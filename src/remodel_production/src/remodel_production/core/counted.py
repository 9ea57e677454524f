"""Numbers of things, for a person."""


def counted(number: int, noun: str) -> str:
    """Return a number with its noun, such as "1 wire" or "2 wires"."""
    return f"{number} {noun}{'' if number == 1 else 's'}"
