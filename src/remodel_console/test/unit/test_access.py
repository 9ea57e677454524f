"""Who is let in, what is recorded, and that nothing a page sends gets further than it may."""

import asyncio
import json

import pytest

from remodel_console.core.access import Actor, Door, Role, is_local, tidy_name
from remodel_console.core.answer import DONE, FAILED, REFUSED
from remodel_console.desk import Desk
from remodel_console.edge.journal import Journal
from remodel_console.errors import CommandError
from remodel_console.web.guard import Guard, role_of

OPERATOR = Actor("Ada", "127.0.0.1", Role.OPERATOR)
WATCHER = Actor("Bob", "127.0.0.1", Role.WATCHER)


def ask(door, path="/", method="GET", body=b"", kind="http", **headers):
    """Return (status, role or text, set-cookie) of what the guard lets through or answers."""
    headers = {"host": "127.0.0.1:80"} | {name: str(text) for name, text in headers.items()}
    path, _, query = path.partition("?")
    scope = {
        "type": kind,
        "method": method,
        "path": path,
        "query_string": query.encode(),
        "headers": [(name.encode(), text.encode()) for name, text in headers.items()],
    }
    sent = []

    async def app(scope, receive, send):
        await send({"type": "http.response.start", "status": 200, "headers": []})
        await send({"type": "http.response.body", "body": role_of(scope).value.encode()})

    async def receive():
        return {"type": "http.request", "body": body, "more_body": False}

    async def send(message):
        sent.append(message)

    asyncio.run(Guard(app, door)(scope, receive, send))
    if sent[0]["type"] == "websocket.close":
        return sent[0]["code"], "", ""
    cookie = dict(sent[0]["headers"]).get(b"set-cookie", b"").decode()
    return sent[0]["status"], sent[1]["body"].decode(), cookie


def test_this_computer_needs_no_token():
    assert ask(Door("127.0.0.1"))[:2] == (200, "operator")


@pytest.mark.parametrize("host", ["evil.example", "192.168.1.4:80", ""])
def test_a_name_that_is_not_this_computer_is_refused(host):
    assert ask(Door("127.0.0.1"), host=host)[0] == 421


def test_a_network_needs_a_token():
    with pytest.raises(ValueError, match="needs a token"):
        Door("0.0.0.0")
    with pytest.raises(ValueError, match="must differ"):
        Door("127.0.0.1", "a", "a")


@pytest.mark.parametrize(("token", "role"), [("open", "operator"), ("look", "watcher")])
def test_a_token_gives_its_role_and_is_kept_in_a_cookie(token, role):
    door = Door("0.0.0.0", "open", "look")
    assert ask(door, host="cell.local")[0] == 401
    assert ask(door, f"/?token={token}")[0] == 401
    status, text, _ = ask(door, "/enter", "POST", b"token=wrong")
    assert status == 401
    assert "Wrong token" in text
    status, _, cookie = ask(door, "/enter", "POST", f"token={token}".encode())
    assert status == 303
    assert {"httponly", "samesite=strict"} <= {p.strip().lower() for p in cookie.split(";")}
    assert ask(door, "/enter?token=" + token)[0] == 303
    assert ask(door, cookie=cookie.split(";")[0])[:2] == (200, role)
    assert ask(door, kind="websocket", path="/_nicegui_ws/socket.io")[0] == 4403
    assert ask(door, cookie="remodel_token=; x")[0] == 401


def test_pages_of_other_sites_are_refused():
    door, foreign = Door("127.0.0.1"), "http://evil.example"
    assert ask(door, method="POST", origin=foreign)[0] == 403
    assert ask(door, origin=foreign)[0] == 200
    socket = "/_nicegui_ws/socket.io"
    assert ask(door, socket, origin=foreign)[0] == 403
    assert ask(door, socket, kind="websocket", origin=foreign)[0] == 4403
    assert ask(door, socket, kind="websocket", origin="null")[0] == 4403
    assert ask(door, socket, kind="websocket", origin="http://127.0.0.1:80")[0] == 200


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
    assert desk.give(WATCHER, "stop", lambda: done.append(1)).state == REFUSED
    assert not done
    lines = (tmp_path / "new" / "commands.jsonl").read_text().splitlines()
    records = [json.loads(line) for line in lines]
    assert [(r["who"], r["role"], r["command"], r["state"]) for r in records] == [
        ("Ada", "operator", "pause", "done"),
        ("Ada", "operator", "stop", "failed"),
        ("Ada", "operator", "lock", "failed"),
        ("Bob", "watcher", "stop", "refused"),
    ]
    assert all(record["time"].endswith("+00:00") for record in records)
