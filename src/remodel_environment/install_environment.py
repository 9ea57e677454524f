#!/usr/bin/env python3
"""Bring the packages of requirements.txt into an install space: install_environment.py FILE PREFIX.

They are copied, with what they require, from the environment of the Python that runs this, so that
no network is needed. PREFIX/venv uses Debian's packages, too, and may be moved with PREFIX.
"""

import shutil
import sys
import sysconfig
import venv
from collections.abc import Iterable, Iterator
from importlib import metadata
from pathlib import Path

try:
    from packaging.requirements import Requirement
except ModuleNotFoundError:
    Requirement = None

REMEDY = "Run `make build`, and build with -DPYTHON_EXECUTABLE=$PWD/.venv/bin/python3."


def required(lines: Iterable[str]) -> dict[str, metadata.Distribution]:
    """Return the distributions, by name, that requirements name, and those that these require.

    Raises:
        SystemExit: this Python lacks one, or has another version.
    """
    waiting = list(map(Requirement, lines))
    found = {}
    for requirement in waiting:  # which grows
        try:
            package = metadata.distribution(requirement.name)
        except metadata.PackageNotFoundError:
            sys.exit(f"install: {sys.executable} has no package {requirement.name!r}. {REMEDY}")
        if package.version not in requirement.specifier:
            sys.exit(
                f"install: {sys.executable} has version {package.version} of "
                f"{requirement.name!r}; needed: {requirement}. {REMEDY}"
            )
        key = (requirement.name, tuple(sorted(requirement.extras)))
        if key not in found:
            found[key] = package
            waiting.extend(inner_requirements(package, requirement.extras))
    return {name: package for (name, _), package in found.items()}


def inner_requirements(
    package: metadata.Distribution, extras: Iterable[str]
) -> Iterator[Requirement]:
    """Yield what a package requires on this system, with some of its extras."""
    for line in package.requires or ():
        inner = Requirement(line)
        if not inner.marker or any(
            inner.marker.evaluate({"extra": name}) for name in (*extras, "")
        ):
            yield inner


def copy_packages(packages: Iterable[metadata.Distribution], target: Path) -> None:
    """Copy the files of packages, those of Debian excepted, into a folder."""
    source = Path(sysconfig.get_path("purelib")).resolve()
    for package in packages:
        for file in package.files or ():
            path = Path(package.locate_file(file)).resolve()
            if path.is_relative_to(source) and path.is_file():
                copy = target / path.relative_to(source)
                copy.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(path, copy)


def main(requirements: Path, prefix: Path) -> None:
    """Make PREFIX/venv, and have catkin's setup files start with any Python 3."""
    if Requirement is None:
        sys.exit(f"install: {sys.executable} has no package 'packaging'. {REMEDY}")
    lines = [line for line in requirements.read_text().splitlines() if line[:1] not in ("", "#")]
    packages = required(lines)
    environment = prefix / "venv"
    venv.create(environment, system_site_packages=True, symlinks=True, clear=True)
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    if sys.prefix != sys.base_prefix:
        copy_packages(packages.values(), environment / "lib" / version / "site-packages")
    # catkin writes the path of the Python that built the workspace, which may be gone.
    setup = prefix / "_setup_util.py"
    _, rest = setup.read_text().split("\n", 1)
    setup.write_text(f"#!/usr/bin/env python3\n{rest}")


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
