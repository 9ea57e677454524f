"""Which parts are splices, by what designs call them."""

from __future__ import annotations

import re

_SPLICE = re.compile(r"splice|splei(?:ss|ß)|[ée]pissure|giunzione|empalme", re.IGNORECASE)


def names_splice(*texts: str) -> bool:
    """Return whether one of some texts names a splice, in one of five languages."""
    return any(_SPLICE.search(text) for text in texts)
