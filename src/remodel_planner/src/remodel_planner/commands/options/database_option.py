"""The option that names the production database, common to all commands."""

import argparse
import os


def add_database_option(parser: argparse.ArgumentParser) -> None:
    """Add --database, by default REMODEL_DATABASE of the environment, else a local file."""
    parser.add_argument(
        "--database",
        metavar="URL",
        default=os.environ.get("REMODEL_DATABASE", "sqlite:///remodel_production.sqlite"),
        help="SQLAlchemy URL of the production database (default: %(default)s)",
    )
