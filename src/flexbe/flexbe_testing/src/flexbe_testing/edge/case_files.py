"""Find and read the files of test cases."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import rospkg

from flexbe_testing.core.case import Case, read_case
from flexbe_testing.edge.case_yaml import load_case
from flexbe_testing.errors import CaseError

_SUFFIX = ".test"
_FOLDER = "tests"


def case_files(names: Sequence[str], package: str) -> list[Path]:
    """Return the files of test cases.

    Args:
        names: paths, absolute or relative to the package, with or without .test; for none, all of
            the package's folder tests/.
        package: name of a ROS package; may be empty if all paths are absolute.

    Raises:
        CaseError: if one cannot be found.
    """
    folder = package_folder(package) if package else Path.cwd()
    if not names:
        found = sorted(folder.glob(f"{_FOLDER}/*{_SUFFIX}")) if package else []
        return [file for file in found if not file.read_text().lstrip().startswith("<")]
    return [_case_file(name, folder) for name in names]


def read_case_file(file: Path) -> Case:
    """Return the test case in a file.

    Raises:
        CaseError: if it is invalid.
    """
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise CaseError(f"cannot read it: {error}") from error
    return read_case(file.stem, load_case(text))


def resource(name: str) -> Path:
    """Return a file that is named absolutely, from home, or as package/folder/file.

    Raises:
        CaseError: if there is no such package.
    """
    if name.startswith(("/", "~")):
        return Path(name).expanduser()
    package, _, rest = name.partition("/")
    return package_folder(package) / rest


def package_folder(package: str) -> Path:
    """Return the folder of a ROS package.

    Raises:
        CaseError: if there is none.
    """
    try:
        return Path(rospkg.RosPack().get_path(package))
    except rospkg.ResourceNotFound as error:
        raise CaseError(f"there is no ROS package {package!r}") from error


def _case_file(name: str, folder: Path) -> Path:
    path = Path(name).expanduser()
    tried = [folder / path, folder / _FOLDER / path]
    tried += [candidate.with_name(candidate.name + _SUFFIX) for candidate in tuple(tried)]
    for candidate in tried:
        if candidate.is_file():
            return candidate
    raise CaseError(f"there is no test case {name!r}; tried {', '.join(map(str, tried))}")
