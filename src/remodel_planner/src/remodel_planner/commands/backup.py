"""`remodel backup FILE`: back the production database up while it is in use."""

from __future__ import annotations

import argparse
from pathlib import Path

from remodel_planner.commands.options.common import add_database_option, refuses
from remodel_production.edge.database.database_backup import back_up


@refuses("backup")
def main(arguments: list[str] | None = None) -> int:
    """Write the backup, and return the exit code."""
    parser = argparse.ArgumentParser(
        prog="remodel backup",
        description="Back the production database up as it is at one moment; it may be in use. "
        "PostgreSQL needs pg_dump.",
        epilog="Exit code: 0 done, 1 refused or failed, 2 wrong usage.",
    )
    parser.add_argument("file", type=Path, metavar="FILE", help="to write")
    parser.add_argument("--replace", action="store_true", help="write over a file that is there")
    add_database_option(parser)
    options = parser.parse_args(arguments)
    back_up(options.database, options.file, replace=options.replace)
    print(f"{options.file}: {options.file.stat().st_size / 1e6:.1f} MB")
    return 0
