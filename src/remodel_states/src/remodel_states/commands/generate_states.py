"""Write the FlexBE states of a package from its table of abilities, config/abilities.yaml."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from remodel_states.core.state_source import state_modules
from remodel_states.core.tables import TableError
from remodel_states.edge.exported_tables import read_abilities_of


def main(words: Sequence[str]) -> int:
    """Write or compare the states; return the exit code."""
    parser = argparse.ArgumentParser("generate_states", description=__doc__)
    parser.add_argument("folder", help="of the package")
    parser.add_argument("--check", action="store_true", help="change nothing; exit with 1 if stale")
    options = parser.parse_args(list(words))
    try:
        stale = write_states(Path(os.path.realpath(options.folder)), options.check)
    except (TableError, OSError) as error:
        sys.stderr.write(f"generate_states: {error}\n")
        return 1
    for file in stale:
        print(f"{'out of date' if options.check else 'written'}: {file}")
    return 1 if stale and options.check else 0


def write_states(folder: Path, only_check: bool = False) -> list[Path]:
    """Write the states of a package; return the files that were not as they should be.

    Raises:
        TableError: if a table cannot be read.
    """
    package, abilities = read_abilities_of(folder)
    modules = folder / "src" / package
    files = {modules / name: text for name, text in state_modules(abilities.values()).items()}
    written = {file: text.encode() for file, text in files.items()}
    stale = [f for f, text in written.items() if not f.is_file() or f.read_bytes() != text]
    for file in stale if not only_check else []:
        file.write_bytes(written[file])
    return stale
