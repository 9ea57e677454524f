"""`rosrun remodel_console users`: who may use the pages of the console."""

from __future__ import annotations

import argparse
import getpass
import sys
from collections.abc import Sequence
from pathlib import Path

from remodel_console.core.access import Account, Role, require_user_name
from remodel_console.edge.users_file import hash_of, read_accounts, write_accounts

USERS = "~/.ros/remodel_console/users.json"


def main(arguments: Sequence[str]) -> int:
    """Add, remove or list users, and return the exit code."""
    options = _read_options(arguments)
    path = Path(options.file).expanduser()
    try:
        accounts = read_accounts(path) if path.exists() else {}
        if options.command == "list":
            for name, account in sorted(accounts.items()):
                how = "" if account.password else ", named by a proxy only"
                sys.stdout.write(f"{name}: {account.role.value}{how}\n")
            return 0
        if options.command == "remove":
            if options.name not in accounts:
                known = ", ".join(sorted(accounts)) or "none"
                raise ValueError(f"there is no user {options.name}; there are: {known}")
            del accounts[options.name]
        else:
            require_user_name(options.name)
            password = "" if options.without_password else hash_of(_ask_password())
            accounts[options.name] = Account(Role(options.role), password)
        write_accounts(path, accounts)
    except (ValueError, OSError) as error:
        sys.stderr.write(f"users: {error}\n")
        return 1
    except KeyboardInterrupt:
        return 130
    did = "removed" if options.command == "remove" else "added"
    sys.stdout.write(f"{did} {options.name}; {path} holds {len(accounts)}\n")
    return 0


def _read_options(arguments: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="users",
        description="Name the users of the console's pages. Changes count at once.",
        epilog="Exit code: 0 done, 1 refused (nothing has changed), 2 wrong usage.",
    )
    parser.add_argument("--file", default=USERS, help="file of the users (default: %(default)s)")
    commands = parser.add_subparsers(dest="command", required=True)
    add = commands.add_parser("add", help="add a user, or change one; asks for the password")
    add.add_argument("name")
    add.add_argument("--role", choices=[role.value for role in Role], required=True)
    add.add_argument(
        "--without-password",
        action="store_true",
        help="a user whom a proxy names (--user-header of the console)",
    )
    remove = commands.add_parser("remove", help="remove a user")
    remove.add_argument("name")
    commands.add_parser("list", help="list the users and their roles")
    return parser.parse_args(arguments[1:])


def _ask_password() -> str:
    """Return the password that is typed twice; without a terminal, the first line of the input."""
    if not sys.stdin.isatty():
        return sys.stdin.readline().rstrip("\n")
    password = getpass.getpass("Password: ")
    if getpass.getpass("Again: ") != password:
        raise ValueError("the two passwords differ")
    return password
