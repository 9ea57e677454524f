"""A format of design files: how a file of it is recognised, and what reads it."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

from remodel_production.core.catalogue import Catalogue
from remodel_production.core.imports.shared.account import Imported
from remodel_production.core.imports.shared.modules import Asked
from remodel_production.core.imports.shared.text_encoding import decode
from remodel_production.core.imports.shared.xml_tree import local_name, parse_xml
from remodel_production.errors import DesignError

_NAME = re.compile(r"[a-z][a-z0-9_-]*")
_BEFORE_MARKUP = "\N{ZERO WIDTH NO-BREAK SPACE} \t\r\n"


@dataclass(frozen=True)
class DesignFile:
    """The content of a design file, by which formats recognise it."""

    data: bytes

    @cached_property
    def text(self) -> str:
        """The decoded content; empty if it is no text."""
        try:
            return decode(self.data)[0]
        except DesignError:
            return ""

    @cached_property
    def xml_root(self) -> str:
        """The local name of the XML root element; empty if the content is no XML."""
        try:
            return local_name(parse_xml(self.data)) if self.is_markup else ""
        except DesignError:
            return ""

    @property
    def is_markup(self) -> bool:
        """Whether the text begins as XML does."""
        return self.text.lstrip(_BEFORE_MARKUP).startswith("<")


@dataclass(frozen=True)
class JoinedFile:
    """A design file after others, as one content; `parts` says which of its lines are whose."""

    data: bytes
    parts: str


ReadModules = Callable[[bytes, str, str, Catalogue, Asked], Imported]
Join = Callable[[Sequence[tuple[str, bytes]], bytes], JoinedFile]


@dataclass(frozen=True)
class DesignFormat:
    """A format of design files.

    Attributes:
        name: the word of the command line: lower-case letters, digits, `_` and `-`.
        title: what its files are, in the plural, for messages.
        fits: whether a file has this format. It judges by the content, and raises nothing.
        read: reads the content of a file as an order with a name. Its other arguments are the name
            of the file and the catalogue of what the file leaves open. It raises DesignError, with
            the place, what was found and what is needed, if the file is refused.
        read_modules: the same with the modules and variant codes that are imported; None: files of
            this format have no modules.
        join: puts a file after others, each with its name and content; None: files of this format
            stand alone. It raises DesignError.

    Raises:
        DesignError: if the name cannot be a word of the command line.
    """

    name: str
    title: str
    fits: Callable[[DesignFile], bool]
    read: Callable[[bytes, str, str, Catalogue], Imported]
    read_modules: ReadModules | None = None
    join: Join | None = None

    def __post_init__(self) -> None:
        """Check the name."""
        if not _NAME.fullmatch(self.name):
            raise DesignError(
                f"name of a design format: {self.name!r} found; needed: lower-case letters, "
                "digits, '_' and '-', a letter first"
            )
