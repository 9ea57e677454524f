"""The checksum by which FlexBE's wire protocol names sources, library entries and paths."""

from __future__ import annotations

import zlib


def checksum(text: str) -> int:
    """Return the Adler-32 sum of the UTF-8 bytes, cut to 31 bits so that it fits an int32 >= 0."""
    return zlib.adler32(text.encode("utf-8")) & 0x7FFFFFFF
