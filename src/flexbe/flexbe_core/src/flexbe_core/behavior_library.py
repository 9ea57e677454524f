"""All behaviors on the ROS package path."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

import rospy

from flexbe_core.edge.packages import (
    Manifest,
    ManifestError,
    packages_exporting,
    read_manifest,
    source_file,
)
from flexbe_core.engine.events import checksum

# [bytes] No manifest is longer; a longer file was written by mistake, or to do harm.
_LONGEST_MANIFEST = 1 << 20


class BehaviorLibrary:
    """The behaviors of all packages that export flexbe_behaviors.

    A behavior's id is the checksum of its package path, package.module. Manifests that cannot be
    read are left out, with one warning each. Behaviors, manifests and packages that are added
    later are found when they are requested.
    """

    def __init__(self) -> None:
        """Read the manifests of all packages."""
        self._warned: set[str] = set()
        self._added: list[tuple[str, str | None]] = []
        self.parse_packages()

    def parse_packages(self) -> None:
        """Read the manifests of all packages again."""
        self._behavior_lib: dict[int, dict[str, str]] = {}
        self._files: dict[int, tuple[Path, int]] = {}
        self._ids: dict[str, int] = {}
        self._folders = packages_exporting("flexbe_behaviors", self._warn)
        for package, folder in self._folders.items():
            self._read_manifests(str(folder), package)
        for path, pkg in self._added:
            self._read_manifests(path, pkg)

    def get_behavior(self, behavior_id: int) -> dict[str, str] | None:
        """Return a behavior's name, package, file and class; None if there is none with this id."""
        if behavior_id not in self._behavior_lib or self._is_outdated(behavior_id):
            self.parse_packages()
        return self._behavior_lib.get(behavior_id)

    def find_behavior(self, name: str) -> tuple[int, dict[str, str]] | tuple[None, None]:
        """Return id and entry of the behavior with this display name, or None twice."""
        found = self._find(name)
        if found is None or self._is_outdated(found):
            self.parse_packages()
            found = self._find(name)
        return (None, None) if found is None else (found, self._behavior_lib[found])

    def count_behaviors(self) -> int:
        """Return the number of behaviors."""
        return len(self._behavior_lib)

    def names(self) -> tuple[str, ...]:
        """Return the display names of all behaviors, sorted."""
        return tuple(sorted({entry["name"] for entry in self._behavior_lib.values()}))

    def get_sourcecode_filepath(self, behavior_id: int, add_tmp: bool = False) -> str | None:
        """Return the path of a behavior's source file; None if there is none.

        Args:
            behavior_id: id of the behavior.
            add_tmp: return the path of the operator's unsaved version instead, which need not
                exist.
        """
        entry = self.get_behavior(behavior_id)
        if entry is None:
            return None
        package = entry["package"].split(".")[0]
        module_path = f"{entry['package']}.{entry['file']}"
        file = source_file(package, module_path, self._folders.get(package))
        if file is None:
            return None
        return str(file.with_name(f"{file.stem}_tmp.py") if add_tmp else file)

    def _add_behavior_manifests(self, path: str, pkg: str | None = None) -> None:
        """Add all behaviors whose manifests lie below a folder, besides those of packages.

        Args:
            path: the folder.
            pkg: package whose behaviors are added; None for all.
        """
        self._added.append((path, pkg))
        self._read_manifests(path, pkg)

    def _read_manifests(self, path: str, pkg: str | None) -> None:
        for file in _xml_files(Path(path)):
            try:
                manifest = _read(file)
            except (OSError, ManifestError) as error:
                self._warn(f"manifest {file} is left out: it {error}")
                continue
            if manifest is not None and pkg in (None, manifest.package):
                self._add(manifest, file)

    def _add(self, manifest: Manifest, file: Path) -> None:
        same = self._find(manifest.name)
        behavior_id = checksum(manifest.package_path)
        if same is not None and same != behavior_id:
            self._warn(
                f"there are two behaviors named {manifest.name!r}: "
                f"{self._files[same][0]} is used, {file} is left out"
            )
            return
        if before := self._behavior_lib.get(behavior_id):
            self._ids.pop(before["name"], None)
        package, _, module = manifest.package_path.rpartition(".")
        self._behavior_lib[behavior_id] = {
            "name": manifest.name,
            "package": package,
            "file": module,
            "class": manifest.class_name,
        }
        self._files[behavior_id] = (file, file.stat().st_mtime_ns)
        self._ids[manifest.name] = behavior_id

    def _find(self, name: str) -> int | None:
        return self._ids.get(name)

    def _is_outdated(self, behavior_id: int) -> bool:
        file, read_at = self._files[behavior_id]
        try:
            return file.stat().st_mtime_ns != read_at
        except OSError:
            return True

    def _warn(self, text: str) -> None:
        if text not in self._warned:
            self._warned.add(text)
            rospy.logwarn("behavior library: %s", text)


def _xml_files(folder: Path) -> Iterator[Path]:
    """Yield the files that may be manifests, in a fixed order; reading a FIFO would never end."""
    try:
        entries = sorted(folder.iterdir())
    except OSError:
        return
    for entry in entries:
        if entry.name.startswith((".", "#")):
            continue
        if entry.is_dir():
            if not entry.is_symlink():
                yield from _xml_files(entry)
        elif entry.suffix == ".xml" and entry.name != "package.xml" and entry.is_file():
            yield entry


def _read(file: Path) -> Manifest | None:
    status = file.stat()
    if status.st_size > _LONGEST_MANIFEST:
        raise ManifestError(f"is {status.st_size} bytes long; at most {_LONGEST_MANIFEST} are read")
    return _read_version(file, (status.st_mtime_ns, status.st_size))


@lru_cache(maxsize=1 << 14)  # each new behavior has all manifests searched
def _read_version(file: Path, _version: tuple[int, int]) -> Manifest | None:
    """Return the manifest that a version of a file holds; None if it holds none."""
    return read_manifest(file.read_bytes())
