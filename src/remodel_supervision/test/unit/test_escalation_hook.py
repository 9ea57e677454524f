"""A hook delivers events by a real program or a real web server, and never holds up a run."""

import http.server
import json
import os
import stat
import threading
import time
from dataclasses import replace
from pathlib import Path

import pytest

from remodel_supervision.core.recovery.judge import NoticeKind, QuestionNotice
from remodel_supervision.edge.escalation_hook import EscalationHook
from remodel_supervision.errors import HookError

NOTICE = QuestionNotice(
    NoticeKind.ASKED, "cell", "house", 7, "W1", 1, "Größe: a ' \" $HOME; `id`", ("retry", "skip"),
    600.0, "set_aside",
)  # fmt: skip
ASKED, TIMED_OUT = NOTICE.data(), replace(NOTICE, event=NoticeKind.TIMED_OUT).data()


@pytest.fixture
def reports():
    return []


def deliver(option, reports, *events):
    """Have a hook deliver events, and return when it has."""
    hook = EscalationHook.from_option(option, reports.append)
    for event in events:
        hook.notify(event)
    hook.close()


def program(folder, text):
    """Return the option of a program with this text, in a folder whose name has a blank."""
    folder = folder / "my hooks"
    folder.mkdir()
    file = folder / "page"
    file.write_text(f"#!/bin/sh\n{text}\n")
    file.chmod(file.stat().st_mode | stat.S_IXUSR)
    return f"command:'{file}' '{folder}/got'"


def got(folder):
    return [json.loads(line) for line in (folder / "my hooks" / "got").read_text().splitlines()]


def test_a_program_gets_each_event_on_its_standard_input_in_order(tmp_path, reports):
    deliver(program(tmp_path, 'cat >>"$1"; echo >>"$1"'), reports, ASKED, TIMED_OUT)
    assert got(tmp_path) == [ASKED, TIMED_OUT]
    assert reports == []


def test_a_program_that_fails_is_reported_and_the_next_event_is_delivered(tmp_path, reports):
    text = 'if grep -q asked; then echo no modem >&2; exit 3; fi; echo \'{"a": 1}\' >"$1"'
    deliver(program(tmp_path, text), reports, ASKED, TIMED_OUT)
    assert got(tmp_path) == [{"a": 1}]
    (report,) = reports
    assert report.endswith("ended with code 3: no modem")


def test_a_program_that_does_not_read_is_no_failure(tmp_path, reports):
    deliver(program(tmp_path, "exit 0"), reports, {"text": "x" * 1_000_000})
    assert reports == []


def test_a_program_that_hangs_is_killed_with_what_it_started(tmp_path, reports):
    text = 'sleep 600 & echo "[$$, $!]" >"$1"; wait'
    hook = EscalationHook.from_option(program(tmp_path, text), reports.append, limit_s=2.0)
    hook.notify(ASKED)
    assert reports == [], "the caller does not wait"
    hook.close()
    (report,) = reports
    assert report.endswith("did not end within 2 s and was killed")
    for process in got(tmp_path)[0]:
        assert not is_running(process)


def is_running(process, limit_s=20.0):
    """Return whether a process still runs after a while that its killing may take."""
    end = time.monotonic() + limit_s
    while time.monotonic() < end:
        try:
            text = Path(f"/proc/{process}/stat").read_text()
        except (FileNotFoundError, ProcessLookupError):
            return False
        if text.rsplit(")", 1)[1].split()[0] == "Z":
            return False
        os.sched_yield()
    return True


class Server(http.server.ThreadingHTTPServer):
    """Keeps what is posted; answers with a status, or not before it is released."""

    def __init__(self):
        super().__init__(("127.0.0.1", 0), Handler)
        self.posted = []
        self.status = 200
        self.hangs = False
        self.released = threading.Event()
        self.url = f"http://127.0.0.1:{self.server_port}/hook/token"


class Handler(http.server.BaseHTTPRequestHandler):
    def do_POST(self):
        body = self.rfile.read(int(self.headers["Content-Length"]))
        self.server.posted.append((self.headers["Content-Type"], json.loads(body)))
        if self.server.hangs:
            self.server.released.wait(30.0)
        self.send_response(self.server.status)
        self.end_headers()

    def log_message(self, *_):
        pass


@pytest.fixture
def server():
    made = Server()
    thread = threading.Thread(target=made.serve_forever, daemon=True)
    thread.start()
    yield made
    made.released.set()
    made.shutdown()
    made.server_close()
    thread.join()


def test_a_web_server_gets_each_event_as_json(server, reports):
    deliver(server.url, reports, ASKED, TIMED_OUT)
    assert server.posted == [("application/json", ASKED), ("application/json", TIMED_OUT)]
    assert reports == []


def test_a_web_server_that_refuses_is_reported_without_the_path_that_may_be_secret(server, reports):
    server.status = 503
    deliver(server.url, reports, ASKED)
    assert reports == ["http://127.0.0.1: answered 503 Service Unavailable"]


def test_a_web_server_that_hangs_or_is_gone_delays_nothing(server, reports):
    server.hangs = True
    hook = EscalationHook.from_option(server.url, reports.append, limit_s=2.0)
    hook.notify(ASKED)
    assert reports == [], "the caller does not wait"
    hook.close()
    deliver("http://127.0.0.1:1/hook", reports, ASKED)
    assert len(reports) == 2
    assert all("cannot be reached: " in report for report in reports)


def test_too_many_events_are_dropped_and_what_is_not_json_is_reported(reports):
    begun, go_on, delivered = threading.Event(), threading.Event(), []

    def deliver(document, _):
        begun.set()
        go_on.wait(30.0)
        delivered.append(json.loads(document))

    hook = EscalationHook("slow", deliver, reports.append)
    hook.notify({"number": 0})
    assert begun.wait(30.0)
    for number in range(1, 102):
        hook.notify({"number": number})
    assert reports == ["slow: 100 events wait already; one was dropped"]
    hook.notify({"number": hook})
    assert "the event is not JSON" in reports[-1]
    go_on.set()
    hook.close(30.0)
    assert [event["number"] for event in delivered] == list(range(101))


def test_a_notice_has_what_docs_supervision_lists():
    assert list(ASKED) == [
        "event", "cell", "order", "run", "task", "question", "text", "choices", "timeout_s", "then",
    ]  # fmt: skip
    assert (ASKED["event"], TIMED_OUT["event"]) == ("question_asked", "question_timed_out")
    assert json.loads(json.dumps(ASKED)) == ASKED


def test_without_an_option_there_is_no_hook():
    assert EscalationHook.from_option("") is None


@pytest.mark.parametrize(
    ("option", "found"),
    [
        ("page-operator", "expected command:"),
        ("ftp://host/x", "expected command:"),
        ("https:///x", "expected command:"),
        ("http://[::1/x", "expected command:"),
        ("command:", "no such program"),
        ("command:/nonexistent/page", "no such program"),
        ("https://ann:secret@host/x", "without user and password"),
        ("https://host:port/x", "expected command:"),
        ("command:sh 'x", "No closing quotation"),
    ],
)
def test_an_option_that_cannot_work_is_refused_at_once(option, found):
    with pytest.raises(HookError, match=found):
        EscalationHook.from_option(option)
