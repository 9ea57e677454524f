"""What designs leave unsaid, or say in words: lines about assumptions; names of splices."""

from __future__ import annotations

import re

from remodel_production.core.catalogue import Catalogue
from remodel_production.core.imports.shared.colours import colour_code, colour_without_shade
from remodel_production.core.imports.shared.units import section_mm2
from remodel_run.findings import UNKNOWN_COLOUR

_SPLICE = re.compile(r"splice|splei(?:ss|ß)|[ée]pissure|giunzione|empalme", re.IGNORECASE)


def names_splice(*texts: str) -> bool:
    """Return whether one of some texts names a splice, in one of five languages."""
    return any(_SPLICE.search(text) for text in texts)


class Assumptions:
    """One line for each assumption, in the order of the file."""

    def __init__(self, catalogue: Catalogue) -> None:
        """Assume a catalogue's defaults."""
        self._catalogue = catalogue
        self.lines: list[str] = []

    def add(self, line: str) -> None:
        """Note an assumption."""
        self.lines.append(line)

    def colour(self, text: str, source: str) -> str:
        """Return the code of a colour, or the default for one that is not known."""
        code = colour_code(text, self._catalogue) if text else None
        if code is not None:
            return code
        code = colour_without_shade(text, self._catalogue)
        if code is not None:
            self.add(f"{source}: colour {text!r} read as {code}")
            return code
        default = self._catalogue.default_colour
        found = f"{text!r} {UNKNOWN_COLOUR}" if text else "not given"
        self.add(f"{source}: colour {found}, {default} taken")
        return default

    def section(self, text: str, source: str, unit: str = "mm2") -> float:
        """Return a section [mm^2], or the default for one that is not understood."""
        section = section_mm2(text, unit) if text else None
        if section is not None:
            return section
        default = self._catalogue.default_section
        found = f"{text!r} not understood" if text else "not given"
        self.add(f"{source}: section {found}, {default:g} mm2 taken")
        return default
