"""Every node ends when it is interrupted while it is being set up: at a random moment of that."""

import os
import random
import signal
import socket
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path
from xmlrpc.client import ServerProxy

import pytest

from remodel_states.edge.exported_tables import read_abilities

SRC = Path(__file__).parents[1] / "src"

# [s] Wall time that a process may take to join, and a node to end; machines are busy.
JOIN_LIMIT_S = 40.0
END_LIMIT_S = 20.0

# [s] From the moment at which the master knows a node to the signal: some nodes serve by then.
LATEST_S = 0.5

NODES = {
    "flexbe/flexbe_onboard/nodes/start_behavior": "",
    "flexbe/flexbe_mirror/nodes/behavior_mirror_sm": "",
    "flexbe/flexbe_input/nodes/behavior_input": "",
    "flexbe/flexbe_widget/nodes/be_action_server": "",
    "flexbe/flexbe_widget/nodes/be_launcher": "",
    "flexbe_synthesizer/nodes/synthesis_server": "",
    "remodel_console/nodes/command_server": "_user_charts:={folder}",
    "remodel_states/nodes/fake_abilities": "",
    "remodel_states/nodes/fake_cell": "_world:={folder}/world",
    "remodel_sim/nodes/cell": "_panel:={src}/remodel_sim/config/panel.yaml",
    "remodel_planner/nodes/use_case_supervisor": "--database sqlite:///{folder}/p.sqlite",
}


def start(words, folder, master):
    return subprocess.Popen(
        [sys.executable, *words],
        env={**os.environ, "ROS_MASTER_URI": master, "ROS_LOG_DIR": str(folder)},
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        # A shell starts what runs in its background with SIGINT ignored.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )


def wait_until(condition, process):
    end = time.monotonic() + JOIN_LIMIT_S
    while not condition():
        assert process.poll() is None, process.communicate()[1]
        assert time.monotonic() < end, "too late"
        time.sleep(0.005)


def answers(port):
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


@pytest.fixture(scope="module")
def master(tmp_path_factory):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    uri = f"http://127.0.0.1:{port}"
    code = f"import rosmaster; rosmaster.rosmaster_main(['--core', '-p', '{port}'])"
    process = start(["-c", code], tmp_path_factory.mktemp("master"), uri)
    wait_until(lambda: answers(port), process)
    yield uri
    process.terminate()
    process.communicate(timeout=END_LIMIT_S)


@contextmanager
def running(node, master, folder):
    """Run a node from the moment at which the master knows it; check how it ends."""
    name = f"/{Path(node).name}"
    words = NODES[node].format(folder=folder, src=SRC).split()
    process = start([SRC / node, f"__name:={name[1:]}", *words], folder, master)
    try:
        with ServerProxy(master) as known:
            wait_until(lambda: known.lookupNode("/test", name)[0] == 1, process)
            yield process, known
        process.send_signal(signal.SIGINT)
        _, log = process.communicate(timeout=END_LIMIT_S)
    finally:
        process.kill()
        process.communicate()
    assert process.returncode == 0, log
    assert "Traceback" not in log, log


@pytest.mark.parametrize("node", NODES)
def test_a_node_that_is_interrupted_while_it_is_set_up_ends(node, master, tmp_path):
    with running(node, master, tmp_path):
        time.sleep(random.uniform(0.0, LATEST_S))  # the moment is what is tested


def test_servers_that_publish_while_ros_closes_their_topics_end_quietly(master, tmp_path):
    with running("remodel_states/nodes/fake_abilities", master, tmp_path) as (process, known):
        wait_until(lambda: len(statuses(known)) == len(read_abilities()), process)


def statuses(known):
    """Return the topics on which action servers publish their status."""
    topics = [name for name, _ in known.getPublishedTopics("/test", "")[2]]
    return [name for name in topics if name.endswith("/status") and "remodel_abilities" in name]
