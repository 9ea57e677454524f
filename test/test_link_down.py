"""A robot whose program goes on when the network link to a laptop that listens goes down.

Robot and laptop are network namespaces. The robot's processes are in a process namespace, too: the
kernel ends them, and removes links and namespaces, when the first of them ends, however that is.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from xmlrpc.client import ServerProxy

import pytest
import rosgraph
import rospy
from flexbe_msgs.msg import BehaviorLog
from remodel_msgs.msg import PickCableActionResult
from std_msgs.msg import Empty

from flexbe_core.testing import wait_until
from flexbe_widget.core.run_watch import ExitCode

APART = ("unshare", "--user", "--map-root-user", "--net", "--pid", "--fork", "--kill-child")
APART += ("--mount-proc",)
ROBOT, LAPTOP = "192.0.2.1", "192.0.2.2"  # of RFC 5737, for documentation
GOALS = 1000  # a connection keeps some 400 for a listener that does not read
LIMIT_S = 90.0
CHART = """\
<statemachine xmlns:ext="urn:remodel:statechart:ext:1" name="Endless Picks" initial="Pick">
  <datamodel>
    <outcome name="failed"/>
    <input name="cable_id" type="string" ext:default="W1"/>
    <input name="cable_end" type="string" ext:default="a"/>
  </datamodel>
  <state id="Pick" type="PickCableState">
    <transition event="picked" target="Pick"/>
    <transition event="failed" target="failed"/>
    <transition event="command_error" target="failed"/>
  </state>
</statemachine>
"""


def hindrance():
    """Return why there can be no network namespaces; empty if there can be."""
    for name, package in (("unshare", "util-linux"), ("ip", "iproute2")):
        if shutil.which(name) is None:
            return f"{name} is not installed: apt-get install {package}"
    tried = subprocess.run([*APART, "true"], capture_output=True, text=True, check=False)
    if tried.returncode == 0:
        return ""
    return f"this machine or container allows no network namespaces: {tried.stderr.strip()}"


@pytest.mark.slow
def test_goals_and_preempts_go_on_while_the_link_to_a_listener_is_down(tmp_path):
    if reason := hindrance():
        pytest.skip(reason)
    robot = subprocess.run(
        [*APART, sys.executable, __file__, tmp_path],
        cwd=tmp_path,
        env={**os.environ, "ROS_LOG_DIR": str(tmp_path)},
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=6 * LIMIT_S,
    )
    assert robot.returncode == 0, robot.stdout[-4000:]


def send_goals_without_link(folder):
    """Send goals, cut the link to a laptop that records all topics, send goals, and preempt."""
    os.environ |= {"ROS_MASTER_URI": f"http://{ROBOT}:11311", "ROS_IP": ROBOT}
    os.environ["ROS_PACKAGE_PATH"] = f"{package(folder)}:{os.environ['ROS_PACKAGE_PATH']}"
    laptop = lay_link()
    subprocess.Popen(["roscore"])
    master = rosgraph.Master("/test")
    expect(lambda: master.is_online() and master.hasParam("/run_id"), "a ROS master")
    rospy.init_node("test")
    picks, logs = [], []
    rospy.Subscriber("remodel_abilities/pickcable/result", PickCableActionResult, picks.append)
    rospy.Subscriber("flexbe/log", BehaviorLog, lambda message: logs.append(message.text))
    preempt = rospy.Publisher("flexbe/command/preempt", Empty, queue_size=1)
    start("remodel_states", "fake_abilities", "_abilities:=PickCable")
    start("flexbe_onboard", "start_behavior", "__name:=engine")
    launcher = start("flexbe_widget", "be_launcher", "-b", "Endless Picks")
    expect(lambda: picks and preempt.get_num_connections(), "a running behavior")
    record = ("rosbag", "record", "--all", "--output-name", folder / "all.bag", "__name:=laptop")
    subprocess.Popen([*laptop, *record])
    expect(lambda: is_all_recorded(master), "a recorder of all topics of the engine")
    run("ip", "link", "set", "to_laptop", "down")
    before = len(picks)
    expect(lambda: len(picks) >= before + GOALS, f"{GOALS} goals without the link")
    preempt.publish()
    code = launcher.wait(LIMIT_S)
    assert code == ExitCode.PREEMPTED, f"be_launcher ended with {code}"
    assert not any("has not returned" in text for text in logs), logs


def package(folder):
    """Make a package with a behavior that sends goals until it is preempted; return its folder."""
    found = folder / "endless_picks"
    (found / "charts").mkdir(parents=True)
    (found / "package.xml").write_text(
        "<package><name>endless_picks</name><export><flexbe_behaviors/></export></package>"
    )
    chart = found / "charts" / "endless_picks.xml"
    chart.write_text(CHART)
    run("rosrun", "flexbe_synthesizer", "synthesize", chart)
    return found


def lay_link():
    """Lay a link from this namespace to that of a laptop; return how programs start there."""
    holder = subprocess.Popen(["unshare", "--net", "sleep", "infinity"])
    namespace = Path(f"/proc/{holder.pid}/ns/net")
    own = Path("/proc/self/ns/net").readlink()
    expect(lambda: namespace.readlink() != own, "a network namespace")
    laptop = ("nsenter", f"--net={namespace}", "env", f"ROS_IP={LAPTOP}")
    run("ip", "link", "add", "to_laptop", "type", "veth", "peer", "name", "to_robot")
    run("ip", "link", "set", "to_robot", "netns", str(holder.pid))
    for where, device, address in (((), "to_laptop", ROBOT), (laptop, "to_robot", LAPTOP)):
        run(*where, "ip", "address", "add", f"{address}/24", "dev", device)
        run(*where, "ip", "link", "set", "lo", "up")
        run(*where, "ip", "link", "set", device, "up")
    return laptop


def is_all_recorded(master):
    """Return whether the engine is connected to the laptop on each topic that it publishes."""
    published, _, _ = master.getSystemState()
    topics = {topic for topic, nodes in published if "/engine" in nodes}
    with ServerProxy(master.lookupNode("/engine")) as engine:
        _, _, connections = engine.getBusInfo("/test")
    return topics <= {topic for _, node, _, _, topic, *_ in connections if node == "/laptop"}


def start(*node):
    return subprocess.Popen(["rosrun", *node])


def run(*words):
    subprocess.run(words, check=True)


def expect(condition, what):
    assert wait_until(condition, LIMIT_S), f"there is not {what} within {LIMIT_S} s"


if __name__ == "__main__":
    send_goals_without_link(Path(sys.argv[1]))
