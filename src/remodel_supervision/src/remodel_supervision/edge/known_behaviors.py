"""The behaviors that packages on the ROS package path offer."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path

import rospkg
from lxml import etree

from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from flexbe_synthesizer.core.chart.model import Chart
from flexbe_synthesizer.core.chart.names import behavior_file


def behavior_charts() -> Path:
    """Return the folder of the charts that remodel_behaviors ships."""
    return Path(rospkg.RosPack().get_path("remodel_behaviors")) / "charts"


def nested_charts() -> Mapping[str, Chart]:
    """Return the charts, by name."""
    path = behavior_charts() / "place_connector.xml"
    chart = parse_chart(path.read_text(encoding="utf-8"), str(path))
    return {chart.name: chart}


_EXPORT = "export/flexbe_behaviors"
_PARSER = etree.XMLParser(resolve_entities=False, no_network=True)


def describes(behavior: str, text: str) -> bool:
    """Return whether a behavior of that name exists, and its description contains a text.

    Only the manifest under the file name that the FlexBE App gives to the behavior is read, so that
    the time does not grow with the number of behaviors.
    """
    file = f"{behavior_file(behavior)}.xml"
    roots = rospkg.get_ros_paths()
    for folder in _folders(tuple((root, _changed_ns(Path(root))) for root in roots)):
        root = _parsed(folder / file)
        if root is not None and root.tag == "behavior" and root.get("name") == behavior:
            return text in (root.findtext("description") or "")
    return False


@lru_cache(maxsize=1)
def _folders(roots: tuple[tuple[str, int], ...]) -> tuple[Path, ...]:
    """Return the folders of manifests below some roots, each with the time of its last change.

    A package that appears changes its root, so that the packages are searched for again.
    """
    packages = rospkg.RosPack([root for root, _ in roots])
    folders = (Path(packages.get_path(name)) for name in packages.list())
    return tuple(folder / "manifest" for folder in folders if _exports(folder / "package.xml"))


def _exports(package: Path) -> bool:
    root = _parsed(package)
    return root is not None and root.find(_EXPORT) is not None


def _changed_ns(folder: Path) -> int:
    try:
        return folder.stat().st_mtime_ns
    except OSError:
        return 0


def _parsed(file: Path) -> etree._Element | None:
    """Return a file's root; None if it is not XML, or not completely written yet."""
    try:
        return etree.parse(str(file), _PARSER).getroot()
    except (OSError, etree.XMLSyntaxError):
        return None
