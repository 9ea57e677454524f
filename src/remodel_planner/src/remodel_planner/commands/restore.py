"""`remodel restore FILE`: put a backup in the place of the production database."""

from __future__ import annotations

import argparse
from pathlib import Path

from remodel_planner.commands.options.common import add_database_option, refuses
from remodel_production.edge.database.database_backup import restore


@refuses("restore")
def main(arguments: list[str] | None = None) -> int:
    """Restore the backup, and return the exit code."""
    parser = argparse.ArgumentParser(
        prog="remodel restore",
        description="Verify a backup of the production database, and put it in its place. It is "
        "refused while a supervisor owns a cell of that database. PostgreSQL needs psql.",
        epilog="Exit code: 0 done, 1 refused or failed, 2 wrong usage.",
    )
    parser.add_argument("file", type=Path, metavar="FILE", help="that `backup` has written")
    parser.add_argument("--replace", action="store_true", help="give up the database that is there")
    add_database_option(parser)
    options = parser.parse_args(arguments)
    restore(options.database, options.file, replace=options.replace)
    print(f"restored from {options.file}")
    return 0
