"""Read a behavior's manifest.

<behavior name="Example Behavior">
  <executable package_path="my_behaviors.example_behavior_sm" class="ExampleBehaviorSM"/>
  ...
</behavior>
"""

from __future__ import annotations

from dataclasses import dataclass
from xml.etree import ElementTree


class ManifestError(ValueError):
    """A manifest that names a behavior, but not well enough to find it."""


@dataclass(frozen=True)
class Manifest:
    """What a manifest says about where the behavior is.

    Attributes:
        name: display name.
        package_path: dotted path of the module, from its package on.
        class_name: class of the behavior; empty if the manifest does not name it.
    """

    name: str
    package_path: str
    class_name: str

    @property
    def package(self) -> str:
        """The ROS package."""
        return self.package_path.split(".")[0]


def read_manifest(text: bytes) -> Manifest | None:
    """Return what a manifest says; None if the file is not a manifest.

    Raises:
        ManifestError: if it is one, and faulty.
    """
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise ManifestError(f"is not well-formed XML: {error}") from error
    if root.tag != "behavior":
        return None
    executable = root.find("executable")
    if executable is None:
        raise ManifestError("has no <executable package_path=... class=...> in its <behavior>")
    name, path = root.get("name", ""), executable.get("package_path", "")
    if not name:
        raise ManifestError("has no name: write <behavior name=...>")
    if not all(part.isidentifier() for part in path.split(".")) or "." not in path:
        raise ManifestError(f"has package_path {path!r}; write package.module, without .py")
    return Manifest(name, path, executable.get("class", ""))
