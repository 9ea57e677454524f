"""Error codes and faults of all packages, from their parsed tables.

remodel_msgs/config/faults.yaml explains the fields; faults.schema.json, beside it, is its form.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

# The package whose table belongs to the contract, and its numbers; other packages have the rest.
CONTRACT = "remodel_msgs"
CONTRACT_CODES = range(0, 500)
OTHER_CODES = range(1000, 10000)

Row = Mapping[str, Any]


@dataclass(frozen=True)
class ListedCode:
    """An error code; `package` is the one whose table lists it."""

    number: int
    name: str
    meaning: str
    remedy: str
    package: str


@dataclass(frozen=True)
class FaultTables:
    """What can go wrong, over all packages.

    Attributes:
        codes: by name, ordered by package, then number.
        faults: rows by name; `codes` are names, in rows with `after` too.
    """

    codes: Mapping[str, ListedCode]
    faults: Mapping[str, Row]

    @property
    def numbers(self) -> dict[str, int]:
        """The numbers of the codes by their names."""
        return {name: code.number for name, code in self.codes.items()}


def join_fault_tables(
    tables: Mapping[str, Sequence[Row]],
) -> tuple[FaultTables, list[str]]:
    """Return the tables of all packages as one, and what contradicts itself in them.

    Args:
        tables: package -> its parsed tables, in the form of the schema; the contract's first.
    """
    each = [(package, table) for package, own in tables.items() for table in own]
    listed = [code for package, table in each for code in _codes(package, table)]
    rows = [row for _, table in each for row in table.get("faults", [])]
    by_name = {row["fault"]: row for row in rows}
    problems = [*_wrong_numbers(listed), *_repeated(listed, rows)]
    problems += [
        f"fault {row['fault']}: after.fault {row['after']['fault']} is not a fault with codes"
        for row in rows
        if "after" in row and "codes" not in by_name.get(row["after"]["fault"], {})
    ]
    if problems:
        return FaultTables({}, {}), problems
    order = list(tables)
    listed.sort(key=lambda code: (order.index(code.package), code.number))
    faults = {name: {**row, "codes": _names(row, by_name)} for name, row in by_name.items()}
    return FaultTables({code.name: code for code in listed}, faults), []


def _codes(package: str, table: Row) -> Iterable[ListedCode]:
    groups = [table.get("no_fault", []), *(row.get("codes", []) for row in table.get("faults", []))]
    for row in (row for group in groups for row in group):
        yield ListedCode(row["code"], row["name"], row["meaning"], row["remedy"], package=package)


def _names(row: Row, by_name: Mapping[str, Row]) -> list[str]:
    source = by_name[row["after"]["fault"]] if "after" in row else row
    return [code["name"] for code in source["codes"]]


def _wrong_numbers(codes: Sequence[ListedCode]) -> Iterable[str]:
    for code in codes:
        allowed = CONTRACT_CODES if code.package == CONTRACT else OTHER_CODES
        if code.number not in allowed:
            yield (
                f"code {code.number} {code.name} of {code.package}: allowed: {allowed.start} to "
                f"{allowed.stop - 1}"
            )


def _repeated(codes: Sequence[ListedCode], rows: Sequence[Row]) -> Iterable[str]:
    seen: dict[object, ListedCode] = {}
    for code in codes:
        for key in (code.number, code.name):
            other = seen.setdefault(key, code)
            if other is not code:
                yield (
                    f"code {code.number} {code.name} of {code.package}: {key} is "
                    f"{other.number} {other.name} of {other.package} already"
                )
    names = [row["fault"] for row in rows]
    yield from (
        f"fault {n}: listed twice" for n in sorted({n for n in names if names.count(n) > 1})
    )
