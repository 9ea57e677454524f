"""The file of users, who has signed in, and the command `rosrun remodel_console users`."""

from __future__ import annotations

import argparse
import getpass
import hashlib
import json
import secrets
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import argon2
from itsdangerous import BadData, URLSafeTimedSerializer

from remodel_console.core.commands import Account, Role, User, require_user_name
from remodel_console.edge.kept_files import private, write_private

LEAST_PASSWORD = 8  # letters
_SIGNED_IN_S = 7 * 24 * 3600  # after which a user signs in again
_OF_OTHERS = 0o077  # bits of a file's mode
_FIRST_WAIT_S, _LONGEST_WAIT_S = 1.0, 60.0  # after wrong passwords: doubled by each
_MOST_WAITS = 1000  # names that are remembered for it
_HASHER = argon2.PasswordHasher()


class UsersFile:
    """Who may use the console; changes of the file count at once."""

    def __init__(self, path: Path) -> None:
        """Read the file, which only its owner may be able to read.

        Raises:
            ValueError: if it is no file of users, or others can read it.
            OSError: if it cannot be read.
        """
        self._path = path
        self._lock = threading.Lock()
        self._stamp: tuple[int, int] | None = None
        self._accounts: Mapping[str, Account] = {}
        self._waits: dict[str, tuple[float, float]] = {}  # (until, how long) by name
        self._unknown = _HASHER.hash(secrets.token_hex())  # as slow to check as a known one
        self._signer = URLSafeTimedSerializer(_secret(path.with_suffix(".key")), "sign-in")
        self._read()

    def account(self, name: str) -> Account | None:
        """Return what the file says of a user now; None if there is none of that name."""
        try:
            self._read()
        except (OSError, ValueError):  # it is being written, or was spoiled: nobody is let in
            return None
        return self._accounts.get(name)

    def sign_in(self, name: str, password: str) -> str:
        """Return the cookie of a user who knows the password; empty for all others.

        It takes some 0.1 s of a core. After a wrong password, the next try counts only some
        seconds later.
        """
        account = self.account(name)
        with self._lock:
            until_s, _ = self._waits.get(name, (0.0, 0.0))
            if time.monotonic() < until_s:
                return ""
        fits = _fits(account.password if account else self._unknown, password)
        if account is None or not fits:
            self._wait(name)
            return ""
        with self._lock:
            self._waits.pop(name, None)
        return str(self._signer.dumps([name, _trace(account)]))

    def user(self, cookie: str) -> User | None:
        """Return who has signed in; None if the cookie is none, is old, or its user has changed."""
        try:
            name, trace = self._signer.loads(cookie, max_age=_SIGNED_IN_S)
        except (BadData, ValueError, TypeError):
            return None
        account = self.account(name)
        if account is None or _trace(account) != trace:
            return None
        return User(name, account.role)

    def _wait(self, name: str) -> None:
        """Have the next try of a name count later."""
        with self._lock:
            _, before_s = self._waits.pop(name, (0.0, 0.0))
            if len(self._waits) >= _MOST_WAITS:
                self._waits.pop(next(iter(self._waits)))
            wait_s = min(_LONGEST_WAIT_S, max(_FIRST_WAIT_S, 2 * before_s))
            self._waits[name] = (time.monotonic() + wait_s, wait_s)

    def _read(self) -> None:
        status = self._path.stat()
        stamp = (status.st_mtime_ns, status.st_size)
        if stamp == self._stamp:
            return
        self._accounts = read_accounts(self._path)
        self._stamp = stamp


def read_accounts(path: Path) -> dict[str, Account]:
    """Return the users of a file, by name.

    The file is a JSON object such as {"ada": {"role": "engineer", "password": HASH}}. A user
    without a password is named by a proxy.

    Raises:
        ValueError: if it is no such file, or other users of the computer can read it.
        OSError: if it cannot be read.
    """
    if path.stat().st_mode & _OF_OTHERS:
        raise ValueError(f"other users can read {path}; forbid that: chmod 600 {path}")
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
        if not isinstance(found, dict):
            raise ValueError("it holds no JSON object")
        return {name: _account(name, stated) for name, stated in found.items()}
    except ValueError as error:
        raise ValueError(
            f"{path}: {error}; correct it, or write it again: rosrun remodel_console users add NAME"
        ) from error


def write_accounts(path: Path, accounts: Mapping[str, Account]) -> None:
    """Write a file of users that only its owner can read, whole or not at all.

    Raises:
        OSError: if it cannot be written.
    """
    stated = {
        name: {"role": account.role.value, "password": account.password}
        for name, account in accounts.items()
    }
    write_private(path, json.dumps(stated, indent=2, ensure_ascii=False) + "\n")


def hash_of(password: str) -> str:
    """Return the hash of a password (Argon2id).

    Raises:
        ValueError: if the password is too short.
    """
    if len(password) < LEAST_PASSWORD:
        raise ValueError(f"the password has fewer than {LEAST_PASSWORD} letters")
    return _HASHER.hash(password)


def _account(name: str, stated: object) -> Account:
    require_user_name(name)
    if not isinstance(stated, dict) or not set(stated) <= {"role", "password"}:
        raise ValueError(f"{name}: expected `role` and `password`, found {stated!r}")
    roles = [role.value for role in Role]
    if stated.get("role") not in roles:
        raise ValueError(f"{name}: role is {stated.get('role')!r}, not one of {', '.join(roles)}")
    password = stated.get("password", "")
    if not isinstance(password, str):
        raise ValueError(f"{name}: the password's hash is no text")
    return Account(Role(stated["role"]), password)


def _fits(known: str, password: str) -> bool:
    try:
        return _HASHER.verify(known, password)
    except (argon2.exceptions.VerificationError, argon2.exceptions.InvalidHashError):
        return False


def _trace(account: Account) -> str:
    """Return what changes with a user's password, so that older cookies count no longer."""
    return hashlib.sha256(account.password.encode()).hexdigest()[:16]


def _secret(path: Path) -> str:
    """Return the secret that signs cookies, which stays the same when the console respawns."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with open(path, "x", encoding="utf-8", opener=private) as file:
            file.write(secrets.token_urlsafe(48))
    except FileExistsError:
        if path.stat().st_mode & _OF_OTHERS:
            raise ValueError(f"other users can read {path}; delete it") from None
    secret = path.read_text(encoding="utf-8")
    if len(secret) < 32:
        raise ValueError(f"{path} holds no secret; delete it")
    return secret


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
