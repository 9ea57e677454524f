"""The behaviors that packages on the ROS package path offer."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import rospkg
from lxml import etree

_EXPORT = "export/flexbe_behaviors"
_PARSER = etree.XMLParser(resolve_entities=False, no_network=True)


def describes(behavior: str, text: str) -> bool:
    """Tell whether a behavior of that name exists, and its description holds a text."""
    for manifest in _manifests():
        root = _parsed(manifest)
        if root is not None and root.tag == "behavior" and root.get("name") == behavior:
            return text in (root.findtext("description") or "")
    return False


def _manifests() -> Iterator[Path]:
    packages = rospkg.RosPack()
    for name in packages.list():
        folder = Path(packages.get_path(name))
        package = _parsed(folder / "package.xml")
        if package is not None and package.find(_EXPORT) is not None:
            yield from sorted((folder / "manifest").glob("*.xml"))


def _parsed(file: Path) -> etree._Element | None:
    """Return a file's root; None if it is no XML: somebody else's, or half written."""
    try:
        return etree.parse(str(file), _PARSER).getroot()
    except (OSError, etree.XMLSyntaxError):
        return None
