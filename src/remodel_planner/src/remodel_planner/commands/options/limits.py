"""Types of options that bound a search."""

import argparse
import math


def seconds(text: str) -> float:
    """Read a limit of time."""
    value = float(text)
    if not math.isfinite(value) or value < 0:
        raise argparse.ArgumentTypeError(f"expected seconds of at least 0, found {text}")
    return value


def seed(text: str) -> int:
    """Read a seed."""
    value = int(text)
    if not 0 <= value < 2**31:
        raise argparse.ArgumentTypeError(f"expected an integer from 0 to 2^31 - 1, found {text}")
    return value


def moves(text: str) -> int:
    """Read a number of moves."""
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError(f"expected a number of moves of at least 1, found {text}")
    return value
