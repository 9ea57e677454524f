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


# rospy as it shuts down: it calls the hooks, and closes the topics after them.
SERVING = """
import threading
import rospy
from flexbe_core.ros import master

closed, hooks, published = threading.Event(), [], []

def shut_down():
    for hook in hooks:
        hook()
    closed.set()

def serve(is_over):
    threading.Thread(target=shut_down).start()
    while not is_over():
        published.append(closed.is_set())
    published.append(closed.is_set())

rospy.on_shutdown = hooks.append
rospy.signal_shutdown = lambda reason: None
assert master.spin(serve) == 0
assert closed.wait(5.0)
assert published and not any(published)
"""


def test_what_a_node_does_in_its_main_thread_ends_before_ros_closes_its_topics():
    ran = subprocess.run(
        [sys.executable, "-c", SERVING], capture_output=True, text=True, timeout=30
    )
    assert ran.returncode == 0, ran.stderr
