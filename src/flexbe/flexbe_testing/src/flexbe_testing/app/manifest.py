"""A behavior's manifest, as the App demands it."""

from __future__ import annotations

from collections.abc import Iterator
from xml.etree import ElementTree

from flexbe_testing.app.behavior import BehaviorUse, walk
from flexbe_testing.app.known import Known
from flexbe_testing.app.load import load_behavior
from flexbe_testing.app.save import behavior_class, behavior_module
from flexbe_testing.app.text import AppLoadError

_DEMANDED = ("author", "description")


def judge_manifest(manifest: str, text: str, known: Known) -> list[str]:
    """Return why the App does not read a manifest, or saves it as something else.

    Args:
        manifest: its text.
        text: the behavior's file.
        known: the states and behaviors of the workspace.
    """
    try:
        root = ElementTree.fromstring(manifest.encode())
        return list(_complaints(root, text, known))
    except (ElementTree.ParseError, AppLoadError) as error:
        return [f"the App cannot read it: {error}"]


def _complaints(root: ElementTree.Element, text: str, known: Known) -> Iterator[str]:
    executables = list(root.iter("executable"))
    if root.tag != "behavior" or len(list(root.iter("behavior"))) != 1 or len(executables) != 1:
        yield "not exactly one <behavior> with one <executable>"
        return
    name, path = root.get("name", ""), executables[0].get("package_path", "")
    package, _, module = path.partition(".")
    if (module, executables[0].get("class")) != (behavior_module(name), behavior_class(name)):
        yield f"the App saves '{name}' as {package}.{behavior_module(name)}/{behavior_class(name)}"
    for tag in _DEMANDED:
        if not (root.findtext(tag) or "").strip():
            yield f"the behavior has no {tag}"
    behavior = load_behavior(text, known)
    if behavior.name != name:
        yield f"the code is of behavior '{behavior.name}', the manifest of '{name}'"
    used = {
        child.content.definition.name
        for _path, child in walk(behavior.root)
        if isinstance(child.content, BehaviorUse)
    }
    listed = {entry.get("name", "") for entry in root.iter("contains")}
    if used != listed:
        yield f"it contains {sorted(listed)}, the code uses {sorted(used)}"
