"""The sections of a behavior file that belong to the person who edits it, not to the generator."""

from __future__ import annotations

import ast
import re
from collections.abc import Mapping

_NAME = re.compile(r"^ +self\.name = (.+)$", re.MULTILINE)
SECTIONS = ("IMPORT", "INIT", "CREATE", "FUNC")


class ManualSectionError(ValueError):
    """A file has no sections that can be kept, so that writing it again would lose something."""


def read_manual_sections(text: str) -> Mapping[str, str]:
    """Return what stands between the tags of each section, to the byte.

    Raises:
        ManualSectionError: if the file has no tags, or a tag without its partner, or twice.
    """
    found: dict[str, str] = {}
    for section in SECTIONS:
        begin, end = f"# [MANUAL_{section}]", f"# [/MANUAL_{section}]"
        if (text.count(begin), text.count(end)) == (0, 0):
            continue
        before, _, rest = text.partition(begin)
        content, mark, after = rest.partition(end)
        if not mark or begin in after or end in before or end in after:
            raise ManualSectionError(
                f"'{begin}' and '{end}' do not appear once each, in this order; correct the tags, "
                "or move the file away"
            )
        found[section] = content
    if not found:
        raise ManualSectionError(
            "it has none of the tags that a generated behavior has, such as '# [MANUAL_INIT]', so "
            "it was written by hand; move it away, or rename the chart"
        )
    return found


def written_name(text: str) -> str | None:
    """Return the name of the behavior that a file says it is; None if it does not say it."""
    found = _NAME.search(text)
    try:
        name = ast.literal_eval(found[1]) if found else None
    except (SyntaxError, ValueError):
        return None
    return name if isinstance(name, str) else None
