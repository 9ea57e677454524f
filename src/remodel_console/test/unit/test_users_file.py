"""The file of users and its command; no ROS."""

import io
import stat

import pytest

from remodel_console.core.commands import Account, Role
from remodel_console.edge import users_file
from remodel_console.edge.users_file import UsersFile, hash_of, main, read_accounts, write_accounts


def users(file, *words, password="correct horse", monkeypatch):
    monkeypatch.setattr("sys.stdin", io.StringIO(f"{password}\n"))
    return main(["users", "--file", str(file), *words])


def test_users_are_added_changed_listed_and_removed(tmp_path, monkeypatch, capsys):
    file = tmp_path / "new" / "users.json"

    def run(*words, **options):
        code = users(file, *words, monkeypatch=monkeypatch, **options)
        return code, "".join(capsys.readouterr())

    assert run("list") == (0, "")
    assert run("add", "ada", "--role", "engineer")[0] == 0
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    assert "correct horse" not in file.read_text()
    assert run("add", "bob", "--role", "watcher", "--without-password")[0] == 0
    assert run("list")[1] == "ada: engineer\nbob: watcher, named by a proxy only\n"
    before = file.read_text()
    for words, reason in (
        (("add", "a b", "--role", "watcher"), "'a b' is no name of a user: 1 to 40 letters"),
        (("remove", "eve"), "there is no user eve; there are: ada, bob"),
    ):
        code, said = run(*words)
        assert code == 1
        assert said.startswith(f"users: {reason}")
    assert "fewer than 8 letters" in run("add", "eve", "--role", "watcher", password="short")[1]
    assert file.read_text() == before
    assert run("remove", "bob")[0] == 0
    assert list(read_accounts(file)) == ["ada"]


@pytest.mark.parametrize(
    ("text", "mode", "reason"),
    [
        ("{}", 0o644, "chmod 600"),
        ("ada", 0o600, "Expecting value"),
        ("[]", 0o600, "no JSON object"),
        ('{"ada": {"role": "chief"}}', 0o600, "role is 'chief', not one of watcher, operator"),
        ('{"ada": {"role": "watcher", "age": 7}}', 0o600, "expected `role` and `password`"),
        ('{"ada": {"role": "watcher", "password": 7}}', 0o600, "hash is no text"),
        ('{"a b": {"role": "watcher"}}', 0o600, "no name of a user"),
    ],
)
def test_what_is_no_file_of_users_is_refused(tmp_path, text, mode, reason):
    file = tmp_path / "users.json"
    file.write_text(text)
    file.chmod(mode)
    with pytest.raises(ValueError, match=reason):
        UsersFile(file)


def test_changes_of_the_file_count_at_once_and_a_restart_keeps_who_is_signed_in(tmp_path):
    file = tmp_path / "users.json"
    ada = Account(Role.OPERATOR, hash_of("correct horse"))
    write_accounts(file, {"ada": ada})
    first = UsersFile(file)
    cookie = first.sign_in("ada", "correct horse")
    assert UsersFile(file).user(cookie).role is Role.OPERATOR
    write_accounts(file, {"ada": Account(Role.ENGINEER, ada.password)})
    assert first.user(cookie).role is Role.ENGINEER
    write_accounts(file, {"ada": Account(Role.ENGINEER, hash_of("another horse"))})
    assert first.user(cookie) is None, "another password"
    write_accounts(file, {})
    assert first.account("ada") is None
    file.write_text("{")
    assert first.account("ada") is None


def test_wrong_passwords_make_the_next_try_wait(tmp_path, monkeypatch):
    now_s = [100.0]
    monkeypatch.setattr(users_file.time, "monotonic", lambda: now_s[0])
    file = tmp_path / "users.json"
    write_accounts(file, {"ada": Account(Role.OPERATOR, hash_of("correct horse"))})
    known = UsersFile(file)
    for wait_s in (1.0, 2.0, 4.0):
        assert known.sign_in("ada", "wrong") == ""
        now_s[0] += wait_s - 0.1
        assert known.sign_in("ada", "correct horse") == "", "too soon"
        now_s[0] += 0.2
    assert known.sign_in("ada", "correct horse")
    assert known.sign_in("ada", "correct horse"), "a right password ends the wait"
