"""The numbers by which FlexBE's nodes name behaviors, sources and paths."""

from __future__ import annotations

import zlib


def checksum(text: str) -> int:
    """Return the checksum of a source, of a path, or of a manifest's `package_path`."""
    return zlib.adler32(text.encode()) & 0x7FFFFFFF
