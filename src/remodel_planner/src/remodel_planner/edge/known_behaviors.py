"""The behaviors that packages on the ROS package path offer."""

from __future__ import annotations

from pathlib import Path

import rospkg
from lxml import etree

_EXPORT = "flexbe_behaviors"
_PARSER = etree.XMLParser(resolve_entities=False, no_network=True)


def describes(behavior: str, text: str) -> bool:
    """Tell whether a behavior of that name exists, and its description holds a text."""
    for manifest in _manifests():
        try:
            root = etree.parse(str(manifest), _PARSER).getroot()
        except (OSError, etree.XMLSyntaxError):
            continue  # somebody else's, or half written: whatever it is, it is not what is asked
        if root.tag == "behavior" and root.get("name") == behavior:
            return text in "".join(root.findtext("description") or "")
    return False


def _manifests() -> list[Path]:
    path = rospkg.RosPack()
    files: list[Path] = []
    for package in path.list():
        if any(export.tag == _EXPORT for export in path.get_manifest(package).exports):
            files += sorted((Path(path.get_path(package)) / "manifest").glob("*.xml"))
    return files
