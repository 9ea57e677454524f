#!/usr/bin/env python3
"""Write all files that are generated from tables: those in remodel_msgs/config, and the docs'.

With --check, change nothing and exit with 1 if a file is out of date.
"""

import argparse
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

ROOT = Path(__file__).parents[1]
SRC = ROOT / "src"
sys.path.insert(0, str(SRC / "remodel_states" / "src"))

from ability_list import with_ability_list  # noqa: E402
from conformance_page import conformance_page  # noqa: E402
from fault_page import fault_page  # noqa: E402
from figure_tables import pages_with_figures  # noqa: E402
from numbers_page import numbers_page  # noqa: E402

from remodel_states.core.state_source import state_modules  # noqa: E402
from remodel_states.core.tables import CONTRACT, FaultTables, TableError  # noqa: E402
from remodel_states.edge.exported_tables import abilities_in, faults_from  # noqa: E402

MSGS = SRC / CONTRACT
README = SRC / "remodel_states/README.md"
STATES = SRC / "remodel_states/src/remodel_states"

# First number of each group of error codes, and what reports them.
GROUPS = {
    1: "1 to 99: contract",
    100: "100 to 199: perception",
    200: "200 to 299: grasping",
    300: "300 to 399: control",
    400: "400 to 499: modelling and planning",
}

ERROR_CODE_HEAD = """\
# Why an ability failed; meaning and remedy of each, and the fault it belongs to: config/faults.yaml
# Written by `make generate`.
"""

CODES_HEAD = '''\
"""The error codes of all abilities, written by `make generate` from the table of remodel_msgs."""

from enum import IntEnum


class Code(IntEnum):
    """Why an ability failed; meaning and remedy of each: docs/reference/faults.md."""

'''


def generated() -> Mapping[Path, str]:
    """Return the generated files with their texts."""
    table = MSGS / "config/abilities.yaml"
    tables = faults_from({CONTRACT: [MSGS / "config/faults.yaml", table]}, MSGS)
    abilities = abilities_in(CONTRACT, table, MSGS, tables.codes, contract=MSGS)
    return {
        **{STATES / name: text for name, text in state_modules(abilities.values()).items()},
        README: with_ability_list(README.read_text(encoding="utf-8"), abilities.values()),
        MSGS / "msg/ErrorCode.msg": error_code_message(tables),
        SRC / "remodel_states/src/remodel_states/core/codes.py": codes_module(tables),
        ROOT / "docs/reference/faults.md": fault_page(tables),
        ROOT / "docs/reference/conformance.md": conformance_page(),
        ROOT / "docs/reference/numbers.md": numbers_page(),
        **dict(pages_with_figures()),
    }


def error_code_message(tables: FaultTables) -> str:
    """Return ErrorCode.msg."""
    return ERROR_CODE_HEAD + "".join(_constants(tables)) + "int16 value  # one of the constants\n"


def _constants(tables: FaultTables) -> Iterator[str]:
    groups = dict(GROUPS)
    for code in tables.codes.values():
        for first in [first for first in groups if first <= code.number]:
            yield f"# {groups.pop(first)}\n"
        yield f"int16 {code.name}={code.number}\n"


def codes_module(tables: FaultTables) -> str:
    """Return the module of the codes for pure cores, which know no messages."""
    codes = tables.codes.values()
    return CODES_HEAD + "".join(f"    {code.name} = {code.number}\n" for code in codes)


def main() -> int:
    """Write the files, or compare them; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--check", action="store_true", help="change nothing; exit with 1 if stale")
    options = parser.parse_args()
    try:
        files = generated()
    except TableError as error:
        print(f"generate: {error}", file=sys.stderr)
        return 1
    stale = [file for file, text in files.items() if not _is(file, text)]
    for file in stale:
        print(f"{'out of date' if options.check else 'written'}: {file.relative_to(ROOT)}")
        if not options.check:
            file.write_text(files[file], encoding="utf-8")
    return 1 if stale and options.check else 0


def _is(file: Path, text: str) -> bool:
    return file.is_file() and file.read_text(encoding="utf-8") == text


if __name__ == "__main__":
    sys.exit(main())
