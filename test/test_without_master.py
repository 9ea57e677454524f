"""Commands without a ROS master: one sentence, an exit code in bounded time, a quiet Ctrl-C."""

import os
import signal
import socket
import subprocess

import pytest

from remodel_planner.commands import import_design

DESIGN = "/usr/share/qelectrotech/examples/tableau_domestique.qet"

# [s] Wall time; a command waits up to 5 s for a master, and Python starts slowly on a busy machine.
LIMIT_S = 40.0

# Each command with the exit code that its help states for a missing master.
COMMANDS = {
    "run_order": (3, "remodel_planner remodel run house --wait 1 --database {database}"),
    "use_case_supervisor": (2, "remodel_planner use_case_supervisor --database {database}"),
    "conformance": (2, "remodel_states conformance remodel_abilities/detectcable DetectCable"),
    "uicommand": (2, "remodel_console uicommand --timeout 1 stop"),
    "engine_conformance": (4, "flexbe_testing engine_conformance"),
    "be_launcher": (4, "flexbe_widget be_launcher --wait 1"),
    "be_launcher -b": (4, "flexbe_widget be_launcher --wait 1 -b my_first_behavior"),
}


@pytest.fixture(scope="module")
def database(tmp_path_factory):
    database = f"sqlite:///{tmp_path_factory.mktemp('master')}/production.sqlite"
    assert import_design.main([DESIGN, "--order", "house", "--database", database]) == 0
    return database


def start(line, database, port):
    return subprocess.Popen(
        ["rosrun", *line.format(database=database).split()],
        env={**os.environ, "ROS_MASTER_URI": f"http://127.0.0.1:{port}"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # A shell starts what runs in its background with SIGINT ignored.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )


def test_without_a_master_each_command_ends_with_a_sentence(database):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))  # bound, but not listening: connections are refused
        port = free.getsockname()[1]
        running = {name: start(line, database, port) for name, (_, line) in COMMANDS.items()}
        for name, process in running.items():
            out, err = process.communicate(timeout=LIMIT_S)
            assert process.returncode == COMMANDS[name][0], (name, out, err)
            said = (out + err).strip()
            assert len(said.splitlines()) == 1, (name, said)
            assert f"no ROS master at http://127.0.0.1:{port}" in said, name
            assert "start one with roscore or roslaunch, or set ROS_MASTER_URI" in said, name


@pytest.mark.parametrize("name", [name for name in COMMANDS if name != "be_launcher -b"])
def test_ctrl_c_while_a_command_waits_is_quiet(name, database):
    with socket.create_server(("127.0.0.1", 0)) as stalled:  # like a master that is stopped
        stalled.settimeout(LIMIT_S)
        process = start(COMMANDS[name][1], database, stalled.getsockname()[1])
        asked, _ = stalled.accept()
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=LIMIT_S)
        asked.close()
    assert process.returncode == 130, (out, err)
    assert (out, err) == ("", "")
