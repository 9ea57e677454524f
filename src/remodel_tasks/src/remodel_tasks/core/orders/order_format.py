"""The format of the files of orders, apart from what reads them, which takes longer to load."""

from __future__ import annotations

FORMAT = "remodel-order-1"


def is_order(data: object) -> bool:
    """Return whether a parsed document is meant as an order."""
    return isinstance(data, dict) and data.get("format") == FORMAT
