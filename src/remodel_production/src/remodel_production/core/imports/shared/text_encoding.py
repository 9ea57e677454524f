"""Decode text of unknown encoding."""

from __future__ import annotations

import codecs

from remodel_production.errors import DesignError

_MARKS = {
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}
# What Western editions of Windows write where they do not write UTF-8.
_FALLBACK = "cp1252"


def decode(data: bytes, encoding: str = "") -> tuple[str, str]:
    """Return the text, and the assumed encoding; empty if it is given, marked or UTF-8.

    Args:
        data: to decode.
        encoding: that is known; empty for: by its mark, else UTF-8, else Windows-1252.

    Raises:
        DesignError: if the data is not in the encoding, or is no text.
    """
    mark = next((name for bom, name in _MARKS.items() if data.startswith(bom)), "")
    try:
        text, assumed = data.decode(encoding or mark or "utf-8"), ""
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        if encoding or mark:
            raise DesignError(
                f"line {line}: byte {data[error.start]:#04x} is no {error.encoding}: give the "
                "file's encoding in the mapping"
            ) from error
        text, assumed = data.decode(_FALLBACK, errors="replace"), _FALLBACK
    except LookupError as error:
        raise DesignError(f"encoding {encoding}: not known; utf-8, utf-16, cp1252 are") from error
    if "\0" in text:
        line = text[: text.index("\0")].count("\n") + 1
        raise DesignError(f"line {line}: a zero byte found; a text is needed, not a binary file")
    return text, assumed
