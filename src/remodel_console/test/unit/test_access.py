"""Who is let in, what is recorded, and that nothing a page sends gets further than it may."""

import asyncio
import json
import subprocess

import pytest

from remodel_console.core.commands import (
    DONE,
    FAILED,
    REFUSED,
    Account,
    Actor,
    Door,
    Role,
    is_local,
    tidy_name,
)
from remodel_console.edge.kept_files import Journal
from remodel_console.edge.users_file import UsersFile, hash_of, write_accounts
from remodel_console.errors import CommandError
from remodel_console.live import Desk
from remodel_console.web.guard import Guard, user_of

OPERATOR = Actor("Ada", "127.0.0.1", Role.OPERATOR)
WATCHER = Actor("Bob", "127.0.0.1", Role.WATCHER)
SOCKET = "/_nicegui_ws/socket.io"


@pytest.fixture
def users(tmp_path):
    accounts = {
        "ada": Account(Role.ENGINEER, hash_of("correct horse")),
        "bob": Account(Role.WATCHER),
    }
    write_accounts(tmp_path / "users.json", accounts)
    return UsersFile(tmp_path / "users.json")


def ask(
    door,
    path="/",
    method="GET",
    body=b"",
    kind="http",
    users=None,
    client="127.0.0.1",
    record=lambda actor, answer: None,
    **headers,
):
    """Return (status, name and role, or text, set-cookie) of what the guard lets through."""
    headers = {"host": "127.0.0.1:80"} | {n.replace("_", "-"): str(v) for n, v in headers.items()}
    path, _, query = path.partition("?")
    scope = {
        "type": kind,
        "method": method,
        "path": path,
        "query_string": query.encode(),
        "client": (client, 50000),
        "headers": [(name.encode(), text.encode()) for name, text in headers.items()],
    }
    sent = []

    async def app(scope, receive, send):
        user = user_of(scope)
        await send({"type": "http.response.start", "status": 200, "headers": []})
        body = f"{user.name} {user.role.value}".encode()
        await send({"type": "http.response.body", "body": body})

    async def receive():
        return {"type": "http.request", "body": body, "more_body": False}

    async def send(message):
        sent.append(message)

    asyncio.run(Guard(app, door, users, record)(scope, receive, send))
    if sent[0]["type"] == "websocket.close":
        return sent[0]["code"], "", ""
    cookie = dict(sent[0]["headers"]).get(b"set-cookie", b"").decode()
    return sent[0]["status"], sent[1]["body"].decode(), cookie


def test_this_computer_needs_no_user():
    assert ask(Door("127.0.0.1"))[:2] == (200, " engineer")


@pytest.mark.parametrize("host", ["evil.example", "192.168.1.4:80", ""])
def test_a_name_that_is_not_this_computer_is_refused(host):
    assert ask(Door("127.0.0.1"), host=host)[0] == 421


def test_a_network_and_a_proxy_need_users():
    with pytest.raises(ValueError, match="users add NAME --role engineer"):
        Door("0.0.0.0")
    with pytest.raises(ValueError, match="--without-password"):
        Door("127.0.0.1", user_header="X-User")


def test_each_role_may_do_what_those_before_it_may():
    assert [[role.may(needed) for needed in Role] for role in Role] == [
        [True, False, False],
        [True, True, False],
        [True, True, True],
    ]


def test_a_user_signs_in_and_out(users):
    door, recorded = Door("0.0.0.0", has_users=True), []

    def asked(*given, **options):
        return ask(
            door,
            *given,
            users=users,
            record=lambda actor, answer: recorded.append((actor.name, answer.state)),
            **options,
        )

    assert asked(host="cell.local")[0] == 401
    assert asked("/?name=ada&password=correct+horse")[0] == 401
    assert asked("/enter?name=ada&password=correct+horse")[::2] == (303, "")
    status, _, cookie = asked("/enter", "POST", b"name=ada&password=correct+horse")
    assert status == 303
    parts = {part.strip().lower() for part in cookie.split(";")}
    assert {"httponly", "samesite=strict"} <= parts
    assert "correct" not in cookie
    signed_in = cookie.split(";")[0]
    assert asked(cookie=signed_in)[:2] == (200, "ada engineer")
    assert asked(SOCKET, kind="websocket", cookie=signed_in)[0] == 200
    assert asked(SOCKET, kind="websocket")[0] == 4403
    for forged in (
        signed_in[:-1],
        "remodel_user=",
        "remodel_user=ada",
        "remodel_user; x",
        "a=\x00",
    ):
        assert asked(cookie=forged)[0] == 401
    assert 'remodel_user=""' in asked("/leave", cookie=signed_in)[2]
    for body in (b"name=ada&password=wrong", b"name=bob&password=", b"name=eve&password=x", b""):
        status, text, cookie = asked("/enter", "POST", body)
        assert (status, cookie) == (401, "")
        assert "Wrong name or password" in text
    assert recorded == [
        ("ada", "done"),
        ("ada", "refused"),
        ("bob", "refused"),
        ("eve", "refused"),
        ("", "refused"),
    ]


def test_a_proxy_names_the_user_and_nobody_else_may(users):
    door = Door(
        "127.0.0.1", True, user_header="X-User", proxies=("10.0.0.2",), public_hosts=("cell.org",)
    )

    def asked(**options):
        return ask(door, users=users, host="cell.org", **options)

    assert asked(client="10.0.0.2", x_user="bob")[:2] == (200, "bob watcher")
    status, text, _ = asked(client="10.0.0.2", x_user="<b>eve")
    assert status == 403
    assert "&#x27;&lt;b&gt;eve&#x27; has no role here" in text
    assert asked(client="10.0.0.2")[0] == 403
    assert asked(client="127.0.0.1", x_user="ada")[0] == 403, "not the proxy"
    assert ask(door, users=users, client="10.0.0.2", host="evil.org", x_user="ada")[0] == 421
    assert asked(client="10.0.0.2", path="/enter", method="POST", body=b"name=ada")[0] == 403


def test_the_launch_files_pass_what_they_are_given_and_no_secret_on_a_command_line():
    """Other users can read a command line, but no environment."""
    given = ("host:=0.0.0.0", "port:=8080", "users:=/u.json", "user_header:=X-User")
    given += ("public_host:=cell.org", "key:=secret", "database:=postgresql://me:secret@db/p")
    for package, file in (
        ("remodel_console", "console.launch"),
        ("flexbe_widget", "behavior_ocs.launch"),
    ):
        line = ["roslaunch", "--args", "/console", package, file, *given]
        printed = subprocess.run(line, capture_output=True, text=True, check=True).stdout
        environment, _, words = printed.partition("/console --")
        assert words.startswith("host 0.0.0.0 --port 8080 --users /u.json --user-header X-User")
        assert "--public-host cell.org" in words
        assert environment.count("secret") == 2
        assert "secret" not in words


def test_pages_of_other_sites_are_refused():
    door, foreign = Door("127.0.0.1"), "http://evil.example"
    assert ask(door, method="POST", origin=foreign)[0] == 403
    assert ask(door, origin=foreign)[0] == 200
    assert ask(door, SOCKET, origin=foreign)[0] == 403
    assert ask(door, SOCKET, kind="websocket", origin=foreign)[0] == 4403
    assert ask(door, SOCKET, kind="websocket", origin="null")[0] == 4403
    assert ask(door, SOCKET, kind="websocket", origin="http://127.0.0.1:80")[0] == 200


@pytest.mark.parametrize(
    ("host", "local"),
    [("127.0.0.1", True), ("::1", True), ("localhost", True), ("0.0.0.0", False), ("", False)],
)
def test_what_is_this_computer(host, local):
    assert is_local(host) is local


def test_names_are_of_one_printable_short_line():
    assert tidy_name("  Ada\n\x1b[31m Lovelace ") == "Ada[31m Lovelace"
    assert tidy_name("x" * 99) == "x" * 40


def test_every_command_is_recorded_with_who_when_and_what_came_of_it(tmp_path):
    desk = Desk(Journal(tmp_path / "new" / "commands.jsonl"))

    def fail():
        raise CommandError("no engine")

    def break_down():
        raise KeyError("x")

    assert desk.give(OPERATOR, "pause", lambda: None).state == DONE
    assert desk.give(OPERATOR, "stop", fail).words == "no engine"
    assert desk.give(OPERATOR, "lock", break_down).state == FAILED
    done = []
    refused = desk.give(WATCHER, "stop", lambda: done.append(1))
    assert (refused.state, refused.words) == (REFUSED, "Bob is a watcher; this needs an operator")
    refused = desk.give(OPERATOR, "save", lambda: done.append(1), Role.ENGINEER)
    assert refused.words == "Ada is an operator; this needs an engineer"
    assert not done
    lines = (tmp_path / "new" / "commands.jsonl").read_text().splitlines()
    records = [json.loads(line) for line in lines]
    assert [(r["who"], r["role"], r["command"], r["state"]) for r in records] == [
        ("Ada", "operator", "pause", "done"),
        ("Ada", "operator", "stop", "failed"),
        ("Ada", "operator", "lock", "failed"),
        ("Bob", "watcher", "stop", "refused"),
        ("Ada", "operator", "save", "refused"),
    ]
    assert all(record["time"].endswith("+00:00") for record in records)
