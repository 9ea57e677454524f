"""Read untrusted XML: no entities, no document type, nothing fetched."""

from __future__ import annotations

from xml.parsers import expat

from lxml import etree

from remodel_production.errors import DesignError


class _RootSeen(Exception):  # noqa: N818 - it ends a search, and is no error
    pass


def parse_xml(text: bytes) -> etree._Element:
    """Return the root element.

    Raises:
        DesignError: if the text is no well-formed XML or declares a document type.
    """
    _refuse_document_type(text)
    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, huge_tree=False, remove_comments=True
    )
    try:
        return etree.fromstring(text, parser)
    except etree.XMLSyntaxError as error:
        raise DesignError(f"is no XML: {error}") from error


def local_name(element: etree._Element) -> str:
    """Return an element's name without its namespace; empty for a processing instruction."""
    tag = element.tag
    return tag.rsplit("}", 1)[-1] if isinstance(tag, str) else ""


def line_of(element: etree._Element) -> str:
    """Return where an element stands in its file."""
    return f"line {element.sourceline}"


def _refuse_document_type(text: bytes) -> None:
    """Refuse entities before they are expanded: only a document type can declare them."""

    def refuse(name: str, *_: object) -> None:
        raise DesignError(
            f"line {parser.CurrentLineNumber}: document type {name} found; files with document "
            "types are not read, since they can declare entities without end: remove <!DOCTYPE>"
        )

    def stop(*_: object) -> None:
        raise _RootSeen

    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = refuse
    parser.StartElementHandler = stop
    try:
        parser.Parse(text, True)
    except _RootSeen:
        return
    except (expat.ExpatError, LookupError, ValueError) as error:
        raise DesignError(f"is no XML: {error}") from error
