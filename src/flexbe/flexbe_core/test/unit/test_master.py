"""The check for a ROS master, and the watch, against masters that are stopped and replaced."""

import queue
import signal
import socket
import threading
import time
from contextlib import contextmanager
from xmlrpc.server import SimpleXMLRPCServer

import pytest
import rospy

from flexbe_core.ros import master
from flexbe_core.ros.master import (
    Identity,
    MasterWatch,
    NoMasterError,
    report_unknown_host,
    require_master,
)

LIMIT_S = 10.0


@pytest.fixture
def port(monkeypatch):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    monkeypatch.setenv("ROS_MASTER_URI", f"http://127.0.0.1:{port}")
    monkeypatch.setattr(master, "WATCH_EVERY_S", 0.02)
    monkeypatch.setattr(master, "CALL_LIMIT_S", 0.2)
    monkeypatch.setattr(master, "SILENCE_S", 0.3)
    return port


@contextmanager
def served(port, pid, run_id):
    """Serve what the check asks a master for."""
    server = SimpleXMLRPCServer(("127.0.0.1", port), logRequests=False)
    server.register_function(lambda caller: (1, "", pid), "getPid")
    server.register_function(
        lambda caller, key: (1, "", run_id) if run_id else (-1, "", 0), "getParam"
    )
    thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
    thread.start()
    try:
        yield
    finally:
        server.shutdown()
        thread.join()
        server.server_close()


class Watched:
    """A watch, and what it has called back."""

    def __init__(self):
        self._events = queue.Queue()
        put = self._events.put
        self._watch = MasterWatch(
            lambda text: put(("restart", text)),
            lambda text: put(("silence", text)),
            lambda: put(("return", "")),
        )

    def next(self):
        return self._events.get(timeout=LIMIT_S)

    def stop(self):
        self._watch.stop()


@pytest.fixture
def watch_after():
    watches = []

    def begin():
        watches.append(Watched())
        return watches[-1]

    yield begin
    for watch in watches:
        watch.stop()


def test_a_master_that_answers_is_enough(port):
    with served(port, 7, "a"):
        require_master(0.0)


def test_a_master_may_take_some_time(port):
    found = threading.Thread(target=require_master, args=(LIMIT_S,))
    found.start()
    with served(port, 7, ""):
        found.join(LIMIT_S)
        assert not found.is_alive()


def test_no_master_is_an_error_with_its_address_and_what_to_do(port):
    with pytest.raises(NoMasterError, match=rf"127.0.0.1:{port} within 0.2 s; start one with"):
        require_master(0.2)


def test_a_master_that_accepts_and_never_answers_is_none(port):
    begin = time.monotonic()
    with socket.create_server(("127.0.0.1", port)), pytest.raises(NoMasterError):
        require_master(0.1)
    assert time.monotonic() - begin < LIMIT_S


@pytest.mark.parametrize("uri", ["nonsense", "http://127.0.0.1:no_port", "http://"])
def test_an_address_that_is_none_is_an_error(uri, monkeypatch):
    monkeypatch.setenv("ROS_MASTER_URI", uri)
    with pytest.raises(NoMasterError, match=uri):
        require_master(0.0)


@pytest.mark.parametrize("later", [(8, "b"), (7, "b"), (8, "")], ids=["other", "same pid", "new"])
def test_another_master_at_the_address_is_a_restart(port, watch_after, later):
    with served(port, 7, "a"):
        watch = watch_after()
    with served(port, *later):
        kind, text = watch.next()
        if kind == "silence":  # a busy machine took long to start the second
            kind, text = watch.next()
    assert kind == "restart"
    assert f"http://127.0.0.1:{port} was restarted" in text
    assert "restart the launch" in text


def test_silence_and_return_are_reported_once_each(port, watch_after):
    with served(port, 7, "a"):
        watch = watch_after()
    kind, text = watch.next()
    assert kind == "silence"
    assert f"http://127.0.0.1:{port} has not answered" in text
    with served(port, 7, "a"):
        assert watch.next() == ("return", "")


def test_a_stopped_master_is_silent(port, watch_after):
    with served(port, 7, "a"):
        watch = watch_after()
    with socket.create_server(("127.0.0.1", port)):
        assert watch.next()[0] == "silence"


def test_a_run_id_that_comes_later_is_no_restart():
    joined = Identity(7, "")
    assert joined.is_same(Identity(7, "a"))
    assert not Identity(7, "a").is_same(Identity(7, "b"))
    assert Identity(7, "a").is_same(Identity(7, ""))


def test_a_node_ends_by_a_signal_that_another_thread_received(port, monkeypatch):
    on_shutdown, overdue = [], threading.Event()
    monkeypatch.setattr(master.rospy, "on_shutdown", on_shutdown.append)
    # This process is no node, and goes on.
    monkeypatch.setattr(master.rospy, "signal_shutdown", lambda reason: None)

    def end(*_):
        for call in on_shutdown:
            call()

    def signal_oneself():
        while len(on_shutdown) < 2:  # of the watch, and of the node that waits
            time.sleep(0.01)
        time.sleep(0.1)
        signal.pthread_kill(threading.get_ident(), signal.SIGUSR1)

    def give_up():
        overdue.set()
        end()

    before = signal.signal(signal.SIGUSR1, end)
    limit = threading.Timer(LIMIT_S, give_up)
    limit.start()
    threading.Thread(target=signal_oneself, daemon=True).start()
    try:
        assert master.spin() == 0
    finally:
        limit.cancel()
        signal.signal(signal.SIGUSR1, before)
    assert not overdue.is_set()


def test_a_host_name_that_does_not_resolve_is_reported(monkeypatch):
    reports = []
    monkeypatch.setattr(rospy, "logwarn", lambda text, *words: reports.append(text % words))
    monkeypatch.delenv("ROS_IP", raising=False)
    monkeypatch.setenv("ROS_HOSTNAME", "localhost")
    report_unknown_host()
    assert reports == []
    monkeypatch.setenv("ROS_HOSTNAME", "gone.invalid")
    report_unknown_host()
    assert len(reports) == 1
    assert "gone.invalid, does not resolve" in reports[0]
