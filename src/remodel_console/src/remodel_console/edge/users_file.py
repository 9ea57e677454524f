"""The file of users: names, roles and hashes of passwords; and who has signed in."""

from __future__ import annotations

import hashlib
import json
import secrets
import threading
import time
from collections.abc import Mapping
from pathlib import Path

import argon2
from itsdangerous import BadData, URLSafeTimedSerializer

from remodel_console.core.access import Account, Role, User, require_user_name
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
