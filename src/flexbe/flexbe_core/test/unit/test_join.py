"""A node that is signalled while it is set up ends when it spins, and does not hang."""

import signal
import subprocess
import sys

import pytest

# rospy as its handler needs it: the main thread holds the lock when the signal arrives.
NODE = """
import os, signal, threading
import rospy
from flexbe_core.ros import master

lock, ended = threading.Lock(), []
rospy.init_node = lambda name, **options: None
rospy.on_shutdown = lambda call: None
rospy.signal_shutdown = lambda reason: ended.append(lock.acquire(timeout=5.0))
master.join("node")
with lock:
    os.kill(os.getpid(), signal.{name})
    assert not ended
assert master.spin() == 0
assert ended == [True]
"""


@pytest.mark.parametrize("name", [signal.SIGINT.name, signal.SIGTERM.name])
def test_a_signal_that_arrives_while_the_node_is_set_up_ends_it_when_it_spins(name):
    code = NODE.format(name=name)
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=30)
    assert ran.returncode == 0, ran.stderr
