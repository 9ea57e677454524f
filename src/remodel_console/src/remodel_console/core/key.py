"""Whether a command may be given: the key that comes with it."""

from __future__ import annotations

import hmac


def is_allowed(given: str, wanted: str) -> bool:
    """Return whether a key is accepted, in a time that does not depend on where it differs.

    A key of blanks counts as none; without a wanted key, every key opens.
    """
    wanted = wanted.strip()
    if not wanted:
        return True
    return hmac.compare_digest(given.strip().encode(), wanted.encode())
