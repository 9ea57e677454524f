"""The files of the skills' numbers: read, checked, replaced by a user's, and listed."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import Any, TypeAlias, get_args, get_type_hints

import rospkg
import yaml

from remodel_skills.parameters import Parameters
from remodel_work.errors import CellError

# By the end of a name: its unit, and the least and the greatest value, unless its file states
# others.
UNITS = {
    "_m_s2": ("m/s^2", (1e-3, 20.0)),
    "_m_s": ("m/s", (1e-4, 2.0)),
    "_rad_s": ("rad/s", (1e-3, 10.0)),
    "_n_m": ("N/m", (1.0, 1e7)),
    "_rad": ("rad", (0.0, math.pi)),
    "_px": ("px", (0.0, 1000.0)),
    "_m": ("m", (0.0, 2.0)),
    "_s": ("s", (0.0, 600.0)),
    "_n": ("N", (0.0, 100.0)),
    "": ("1", (0.0, 100.0)),
}


class ParameterError(CellError):
    """Files of parameters are invalid.

    Attributes:
        problems: every problem found: its place, what was found, what is allowed.
    """

    def __init__(self, problems: Sequence[str]) -> None:
        """List every problem at once."""
        lines = "\n".join(f"  - {problem}" for problem in problems)
        super().__init__(f"parameters of skills: {len(problems)} problems:\n{lines}")
        self.problems = tuple(problems)


# What a file holds, and the type of a field.
Value: TypeAlias = Any
Kind: TypeAlias = Any
GROUPS: dict[str, Kind] = get_type_hints(Parameters)


@dataclass(frozen=True)
class Entry:
    """One entry of a file, as it was read.

    Attributes:
        content: its keys and values.
        file: where it stands.
        line: its first line there.
    """

    content: Value
    file: str
    line: int


@dataclass(frozen=True)
class Parameter:
    """One number in force.

    Attributes:
        name: its file and field, such as "motion.travel_z_m".
        value: in SI units, as the field has it.
        shown: as the file has it.
        unit: of the file.
        meaning: what it is.
        origin: where the value comes from.
        file: that has the value, and the line.
        is_own: whether it is a user's own file.
        allowed: the least and the greatest value, in SI units.
    """

    name: str
    value: Value
    shown: Value
    unit: str
    meaning: str
    origin: str
    file: str
    is_own: bool
    allowed: tuple[float, float]


@dataclass(frozen=True)
class InForce:
    """The numbers in force, and where each comes from."""

    parameters: Parameters
    table: tuple[Parameter, ...]


def in_force(
    shipped: Mapping[str, Mapping[str, Entry]], own: Mapping[str, Mapping[str, Entry]]
) -> InForce:
    """Return the shipped numbers, each replaced by the one of a user's own files if it is there.

    Args:
        shipped: the entries of each file, by group and field; all there are.
        own: the same; any of them.

    Raises:
        ParameterError: with everything that is wrong.
    """
    problems: list[str] = []
    found: dict[str, Parameter] = {}
    for group, entries in (*shipped.items(), *own.items()):
        hints = get_type_hints(GROUPS[group])
        for field, entry in entries.items():
            name = f"{group}.{field}"
            if field not in hints:
                near = get_close_matches(field, hints, n=3) or sorted(hints)
                problems.append(f"{_at(entry, name)} is no parameter; there are: {', '.join(near)}")
                continue
            read = _read(name, hints[field], entry, found.get(name))
            if isinstance(read, Parameter):
                found[name] = read
            else:
                problems.extend(f"{_at(entry, name)} {text}" for text in read)
    named = {f"{group}.{field.name}" for group, kind in GROUPS.items() for field in fields(kind)}
    known = {f"{group}.{field}" for group, entries in shipped.items() for field in entries}
    problems.extend(f"{name} is in no file" for name in sorted(named - known))
    if problems:
        raise ParameterError(problems)
    made = {
        group: kind(**{f.name: found[f"{group}.{f.name}"].value for f in fields(kind)})
        for group, kind in GROUPS.items()
    }
    return InForce(Parameters(**made), tuple(found.values()))


def _at(entry: Entry, name: str) -> str:
    return f"{entry.file}:{entry.line}: {name}"


def _read(name: str, kind: Kind, entry: Entry, default: Parameter | None) -> Parameter | list[str]:
    """Return what an entry says, or what is wrong with it."""
    content = entry.content
    needed = ("value", "unit", "origin") if default else ("value", "unit", "meaning", "origin")
    if not isinstance(content, dict) or any(key not in content for key in needed):
        return [f"is {content!r}; it needs {', '.join(needed)}"]
    known = {"value", "unit", "meaning", "origin"} | ({"allowed"} if default is None else set())
    unknown = sorted(set(map(str, content)) - known)
    if unknown:
        return [f"has {', '.join(map(repr, unknown))}; allowed: {', '.join(sorted(known))}"]
    unit, (least, most) = next(of for end, of in UNITS.items() if name.endswith(end))
    given = str(content["unit"])
    units = (unit, "deg") if unit == "rad" else (unit,)
    if given not in units:
        return [f"is in {given!r}; allowed: {' or '.join(units)}"]
    scaled = math.radians if given == "deg" else float
    shown = content["value"]
    if not _fits(shown, kind):
        return [f"is {shown!r}; allowed: {_named(kind)} (YAML takes 6e4 for text: write 6.0e+4)"]
    if default is not None:
        least, most = default.allowed
    elif "allowed" in content:
        least, most = (scaled(limit) for limit in content["allowed"])
    bad = [x for x in _numbers(shown) if not least <= scaled(x) <= most]
    if bad:
        back = math.degrees if given == "deg" else float
        return [f"is {bad[0]:g} {given}; allowed: {back(least):g} to {back(most):g} {given}"]
    return Parameter(
        name=name,
        value=_frozen(shown, kind, scaled),
        shown=shown,
        unit=given,
        meaning=str(content.get("meaning") or (default.meaning if default else "")),
        origin=str(content["origin"]),
        file=f"{entry.file}:{entry.line}",
        is_own=default is not None,
        allowed=(least, most),
    )


def _fits(value: Value, kind: Kind) -> bool:
    """Return whether a value of a file is of a field's type, its numbers finite."""
    if kind is int:
        return isinstance(value, int) and not isinstance(value, bool)
    if kind is float:
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        return is_number and math.isfinite(value)
    first, *others = get_args(kind)
    if not isinstance(value, list):
        return False
    if others == [...]:
        return bool(value) and all(_fits(each, first) for each in value)
    kinds = get_args(kind)
    return len(value) == len(kinds) and all(map(_fits, value, kinds))


def _named(kind: Kind) -> str:
    """Return what a value is to be, for a person."""
    if kind in (int, float):
        return "a whole number" if kind is int else "a number"
    first, *others = get_args(kind)
    if others == [...]:
        return "a list of " + ("numbers" if first is float else f"lists of {len(get_args(first))}")
    return f"a list of {len(others) + 1} numbers"


def _numbers(value: Value) -> Iterator[float]:
    if isinstance(value, list):
        for each in value:
            yield from _numbers(each)
    else:
        yield value


def _frozen(value: Value, kind: Kind, scaled: Callable[[float], float]) -> Value:
    """Return a value as its field has it: lists are tuples, numbers in SI units."""
    if isinstance(value, list):
        of = get_args(kind)
        kinds = [of[0]] * len(value) if of[-1] is ... else of
        return tuple(
            _frozen(each, each_kind, scaled) for each, each_kind in zip(value, kinds, strict=True)
        )
    return value if kind is int else scaled(value)


# A folder with files like the package's own, whose entries replace those of the same name.
VARIABLE = "REMODEL_SKILLS"
LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def read_parameters() -> InForce:
    """Read the package's parameters, and those of the folder that REMODEL_SKILLS names.

    Raises:
        ParameterError: with everything that is wrong, each with its file and line.
    """
    return parameters_with(os.environ.get(VARIABLE, ""))


@cache
def parameters_with(own: str) -> InForce:
    """Read the package's parameters, and those of a user's own folder; "": there is none.

    They are read once in a process.

    Raises:
        ParameterError: see `read_parameters`.
    """
    folder = Path(rospkg.RosPack().get_path("remodel_skills")) / "parameters"
    shipped = dict(_read_file(folder / f"{group}.yaml") for group in GROUPS)
    return in_force(shipped, dict(_own_files(Path(own))) if own else {})


def _own_files(folder: Path) -> Iterator[tuple[str, dict[str, Entry]]]:
    files = sorted(folder.glob("*.yaml"))
    if not files:
        raise ParameterError([f"{VARIABLE} names {folder}, which has no file; allowed: {_names()}"])
    for file in files:
        if file.stem not in GROUPS:
            raise ParameterError([f"{file} is no file of parameters; allowed: {_names()}"])
        yield _read_file(file)


def _names() -> str:
    return ", ".join(f"{group}.yaml" for group in GROUPS)


def _read_file(file: Path) -> tuple[str, dict[str, Entry]]:
    """Return the group of a file, and its entries by field; raises ParameterError."""
    try:
        loader = LOADER(file.read_text())
        node = loader.get_single_node()
    except (OSError, yaml.YAMLError) as error:
        raise ParameterError([f"{file} cannot be read: {error}"]) from error
    if not isinstance(node, yaml.MappingNode):
        raise ParameterError([f"{file} holds no parameters; allowed: names, each with its value"])
    entries: dict[str, Entry] = {}
    for key, value in node.value:
        line = key.start_mark.line + 1
        if key.value in entries:
            first = entries[key.value].line
            raise ParameterError(
                [f"{file}:{line}: {file.stem}.{key.value} stands in line {first}, too"]
            )
        content = loader.construct_object(value, deep=True)
        entries[key.value] = Entry(content, str(file), line)
    return file.stem, entries
