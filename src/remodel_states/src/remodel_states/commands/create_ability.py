"""Create a package with one new ability: action, table row, server, state, chart and test."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from rospkg import RosPack

from remodel_states.commands.generate_states import write_states
from remodel_states.core.state_source import name_problems, package_files, snake_case
from remodel_states.core.tables import OTHER_CODES, TableError
from remodel_states.edge.exported_tables import read_abilities, read_faults

NEXT = """\
next:
  build the workspace, source it, then run: rostest {package} {module}.test
  write your ability into these five files, then run: rosrun remodel_states generate_states {folder}
    action/{ability}.action
    config/abilities.yaml
    src/{package}/{module}_server.py
    test/rostest/{module}_test.py
    charts/{module}.xml
"""


def main(words: Sequence[str]) -> int:
    """Create the package; return the exit code."""
    options = _arguments(words)
    ability, package = options.ability, options.package or snake_case(options.ability)
    folder = Path(os.path.realpath(options.into)) / package
    try:
        problems = [*name_problems(ability, package), *_taken(ability, package, folder)]
        if problems:
            raise TableError("create_ability", problems)
        templates = Path(RosPack().get_path("remodel_states")) / "templates/ability"
        files = package_files(read_templates(templates), ability, package, _free_code())
        write_package(folder, files)
        write_states(folder)
    except (TableError, OSError) as error:
        sys.stderr.write(f"create_ability: {error}\n")
        return 1
    print(f"created {folder}")
    names = {"ability": ability, "package": package, "module": snake_case(ability)}
    print(NEXT.format(folder=folder, **names), end="")
    return 0


def _arguments(words: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser("create_ability", description=__doc__)
    parser.add_argument("ability", help="its name, a verb and a noun such as CrimpFerrule")
    parser.add_argument("--package", default="", help="name of the package (crimp_ferrule)")
    parser.add_argument("--into", default=".", metavar="DIR", help="where to create it (here)")
    return parser.parse_args(list(words))


def _taken(ability: str, package: str, folder: Path) -> list[str]:
    problems = []
    if ability in read_abilities():
        problems.append(f"there is an ability {ability} already; choose another name")
    if package in RosPack().list():
        problems.append(f"there is a package {package} already; choose another by --package")
    if folder.exists():
        problems.append(f"{folder} exists already; choose another place by --into")
    return problems


def _free_code() -> int:
    """Return the first number after those of all tables."""
    return max([OTHER_CODES.start - 1, *read_faults().numbers.values()]) + 1


# Folders whose files are programs.
_PROGRAMS = ("nodes", "test/rostest")


def read_templates(folder: Path) -> dict[str, str]:
    """Return the templates below a folder: path in it -> text."""
    files = sorted(path for path in folder.rglob("*.in") if path.is_file())
    return {str(file.relative_to(folder)): file.read_text(encoding="utf-8") for file in files}


def write_package(folder: Path, files: Mapping[str, str]) -> None:
    """Write the files of a new package; `folder` must not exist."""
    folder.mkdir(parents=True)
    for path, text in files.items():
        file = folder / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
        if text.startswith("#!") and path.startswith(_PROGRAMS):
            file.chmod(0o755)
