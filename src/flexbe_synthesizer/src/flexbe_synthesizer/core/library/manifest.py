"""The one reader and writer of FlexBE's behavior manifests."""

from __future__ import annotations

import html
from dataclasses import dataclass

from flexbe_synthesizer.core.chart.problem import ChartError
from flexbe_synthesizer.core.chart.xml_reader import XmlElement, as_utf8, read_root, read_utf8

AUTHOR = "REMODEL planner developers"  # the FlexBE App wants one, where a chart names none
DATE = "undated"  # the same chart must give the same bytes on every day


@dataclass(frozen=True)
class ManifestParameter:
    """A parameter that a behavior offers: `kind` is enum, numeric, boolean, text or yaml."""

    name: str
    kind: str


@dataclass(frozen=True)
class Manifest:
    """What the manifest of a behavior states.

    Attributes:
        name: display name, the key of the behavior everywhere.
        package: ROS package and Python package.
        module: module below the package, dotted if it lies deeper.
        contains: display names of the behaviors used in it.
        parameters: read only; behaviors made from charts have none.
    """

    name: str
    package: str
    module: str
    class_name: str
    contains: tuple[str, ...] = ()
    parameters: tuple[ManifestParameter, ...] = ()


def read_manifest(text: str | bytes, file: str) -> Manifest | None:
    """Return the manifest that the text holds, None if it is XML of another kind or no XML."""
    try:
        data = as_utf8(text, file)
        if read_root(data)[0] != "behavior":
            return None  # a chart, for one, which may be large
        root = read_utf8(data, file).root
    except ChartError:
        return None
    executable = _child(root, "executable")
    if executable is None:
        return None
    package, _, module = _attribute(executable, "package_path").partition(".")
    if not package or not module:
        return None
    params = _child(root, "params")
    return Manifest(
        name=_attribute(root, "name"),
        package=package,
        module=module,
        class_name=_attribute(executable, "class"),
        contains=tuple(_attribute(c, "name") for c in root.children if c.name == "contains"),
        parameters=tuple(
            ManifestParameter(_attribute(param, "name"), _attribute(param, "type"))
            for param in (params.children if params else ())
            if param.name == "param"
        ),
    )


def _child(element: XmlElement, name: str) -> XmlElement | None:
    return next((child for child in element.children if child.name == name), None)


def _attribute(element: XmlElement, name: str) -> str:
    return next((a.value for a in element.attributes if a.name == name), "")


def write_manifest(manifest: Manifest, description: str, author: str = "", tags: str = "") -> str:
    """Return the manifest's text, in the order in which the FlexBE App writes it."""
    contains = "".join(f"\t<contains name={_quoted(name)} />\n" for name in manifest.contains)
    return f"""<?xml version="1.0" encoding="UTF-8"?>

<behavior name={_quoted(manifest.name)}>

\t<executable package_path={_quoted(f"{manifest.package}.{manifest.module}")} \
class={_quoted(manifest.class_name)} />
\t<tagstring>{html.escape(tags, quote=False)}</tagstring>
\t<author>{html.escape(author or AUTHOR, quote=False)}</author>
\t<date>{DATE}</date>
\t<description>
\t\t{html.escape(description, quote=False)}
\t</description>


\t<!-- Contained Behaviors -->
{contains}
\t<!-- Available Parameters -->

</behavior>"""


def _quoted(value: str) -> str:
    return f'"{html.escape(value)}"'
