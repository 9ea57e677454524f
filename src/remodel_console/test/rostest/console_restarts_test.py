#!/usr/bin/env python3
"""Runtime control while nodes come, go and come back, and a run is begun where another one was."""

import contextlib
import json
import os
import re
import subprocess
import sys
import threading
from pathlib import Path

import rospy
import rostest
from playwright.sync_api import expect
from sensor_msgs.msg import Image
from std_srvs.srv import Trigger, TriggerResponse

sys.path.insert(0, str(Path(__file__).parent))
from console_case import ConsoleCase
from fake_cell import FakeCell
from fake_supervisor import FakeRecords, FakeSupervisor

from remodel_console.core.commands import Account, Role
from remodel_console.edge.users_file import hash_of, write_accounts
from remodel_console.testing.browser_test import LIMIT_S, free_port
from remodel_supervision.core.runs.events import Ending, RunEnded

REPORTED_S = 15.0  # of the recorded run, at which Report is active
SEES_PATROL = """() => !window.isOld && document.querySelector('li.node.active')
  && document.querySelector('.attach')?.textContent.includes("'Patrol' runs unattended.")"""
# Report to a page's server that a disabled box was changed.
PRETEND = """(box) =>
  getElement(box.closest('[id^="c"]').id.slice(1)).$emit('update:model-value', false)"""


class ConsoleRestartsTest(ConsoleCase):
    def test_a_run_starts_where_a_replayed_one_was(self):
        cell, supervisor = FakeCell(), FakeSupervisor()
        self.addCleanup(cell.close)
        asked, rebuilt = self.serve_reset()
        supervisor.run("cabinet 7")
        self.load(self.page, "Errand")
        self.choose(self.page, "Autonomy", "Low")
        self.page.get_by_label("greeting").fill("good night")
        self.press(self.page, "Start")
        expect(self.page.locator(".request")).to_contain_text("Leave 'Report' with 'done'?")
        report_s = self.recorded_s("/Report")
        supervisor.add(RunEnded(Ending.STOPPED, "stopped by an operator"))
        self.press(self.page, "done")
        expect(self.page.locator(".ending")).to_have_text("The last run ended with 'finished'.")
        self.page.close()
        _records = FakeRecords(report_s - REPORTED_S)
        page = self.page = self.open_page("/replay?run=12")
        start = page.get_by_role("button", name="Start from here")
        expect(start).to_be_disabled()
        expect(page.get_by_text("No state was active at this moment.")).to_be_visible()
        where = page.locator(".headline .where")
        page.keyboard.press("n")
        expect(where).to_have_text("Search / Look closer")
        expect(start).to_be_enabled()
        start.click()
        dialog = page.get_by_role("dialog")
        expect(dialog).to_contain_text("Start 'Errand' at Search / Look closer")
        expect(dialog).to_contain_text("No console recorded which values")
        dialog.get_by_label("greeting").fill("good day")
        dialog.get_by_role("button", name="Start", exact=True).click()
        expect(page).to_have_url(re.compile("/runtime$"))
        expect(page.locator(".ending")).to_have_text("The last run ended with 'finished'.")
        passed = "li.node.passed[data-path='{}']"
        expect(page.locator(passed.format("Search/Look closer")).first).to_be_attached()
        expect(page.locator(passed.format("Greet"))).to_have_count(0)
        expect(page.locator(passed.format("Search/Look"))).to_have_count(0)
        page.goto(f"http://127.0.0.1:{self.port}/replay?run=12")
        expect(start).to_be_disabled()
        for _ in range(3):
            page.keyboard.press("n")
        expect(where).to_have_text("Report")
        start.click()
        expect(dialog).to_contain_text("The state gets the values that it found in this run")
        expect(dialog.get_by_label("greeting")).to_have_value("'good night'")
        expect(dialog.locator(".differences")).to_contain_text("W4 lies up to")
        self.take_picture(page, "replay-start")
        dialog.get_by_role("checkbox", name="Rebuild the panel first").click()
        dialog.get_by_role("button", name="Start", exact=True).click()
        self.assertTrue(asked.wait(LIMIT_S))
        page.keyboard.press("Escape")
        expect(dialog).to_have_count(0)
        rebuilt.set()
        expect(page).to_have_url(re.compile("/runtime$"))
        expect(page.locator(".ending")).to_have_text("The last run ended with 'finished'.")
        commands = [json.loads(line)["command"] for line in self.record.read_text().splitlines()]
        for place in (
            "/Search/Look closer level full greeting=good day",
            "/Report level full gree",
        ):
            self.assertTrue([one for one in commands if f"start 'Errand' at {place}" in one], place)

    def serve_reset(self):
        """Serve a simulated cell's reset; return events: it is asked for, and it may answer."""
        asked, rebuilt = threading.Event(), threading.Event()

        def reset(_request):
            asked.set()
            return TriggerResponse(rebuilt.wait(LIMIT_S), "panel rebuilt, no wire on it")

        camera = rospy.Publisher("cell/overhead/image_raw", Image, queue_size=1)
        self.addCleanup(camera.unregister)
        self.addCleanup(rospy.Service("cell/reset", Trigger, reset).shutdown)
        return asked, rebuilt

    def recorded_s(self, path):
        """Return when the values that a state found were read, once they are recorded [ROS s]."""
        scenes = self.folder / ".ros/remodel_console/scenes"

        def found():
            for file in scenes.glob("*.jsonl"):
                for line in file.read_text().splitlines()[1:]:
                    with contextlib.suppress(ValueError, KeyError):
                        time_s, at, _ = json.loads(line)[1]["values"]
                        if at == path:
                            return time_s
            return None

        self.wait_until(found, "a recording of values")
        return found()

    def test_what_is_killed_is_shown_and_found_again(self):
        self.load(self.page, "Patrol")
        self.press(self.page, "Start")
        expect(self.page.locator("li.node.active")).not_to_have_count(0)
        self.kill("engine")
        notice = self.page.locator(".notice", has_text="The engine is not running")
        expect(notice).to_be_visible()
        expect(self.page.locator("li.node.active")).to_have_count(0)
        self.take_picture(self.page, "runtime-engine-away")
        self.start_engine()
        expect(notice).to_have_count(0)
        expect(self.page.locator(".state")).to_have_text("idle")
        self.press(self.page, "Start")
        expect(self.page.locator("li.node.active")).not_to_have_count(0)
        self.kill("mirror")
        expect(self.page.locator(".notice", has_text="The mirror is not running")).to_be_visible()
        self.start_mirror()
        expect(self.page.locator(".notice", has_text="mirror")).to_have_count(0)
        self.page.evaluate("() => { window.isOld = true; }")
        self.kill("console")
        away = self.page.get_by_text("The console does not answer:")
        expect(away).to_be_visible()
        self.take_picture(self.page, "runtime-console-away")
        self.start_console()
        self.page.wait_for_function(SEES_PATROL)

    def test_what_is_pressed_while_the_console_is_stalled_is_not_lost(self):
        page = self.page
        self.load(page, "Patrol")
        self.press(page, "Start")
        self.press(page, "Stop")
        yes = page.get_by_role("dialog").get_by_role("button", name="Stop", exact=True)
        expect(yes).to_be_visible()
        away = page.get_by_text("The console does not answer:")
        with self.stalled("console"):
            yes.click()
            expect(away).to_be_visible()
        expect(page.locator(".ending")).to_have_text("The last run was stopped.")
        expect(away).to_be_hidden()

    def test_who_only_watches_sees_ros_come_late_go_and_come_back(self):
        port, master = free_port(), free_port()
        uri = {"ROS_MASTER_URI": f"http://127.0.0.1:{master}"}
        users = self.folder / "users.json"
        accounts = {
            "bob": Account(Role.WATCHER, hash_of("watch horse")),
            "ann": Account(Role.OPERATOR, hash_of("drive horse")),
        }
        write_accounts(users, accounts)
        self.start_console_at("late", port, "--users", str(users), **uri)
        page = self.open_page(port=port)
        expect(page.get_by_text("Sign in to use this console.")).to_be_visible()
        page.get_by_label("Name").fill("bob")
        page.get_by_label("Password").fill("watch horse")
        page.get_by_role("button", name="Sign in").click()
        expect(page.locator(".bar .user")).to_have_text("bob, watcher")
        expect(page.get_by_text("read-only")).to_be_visible()
        page.get_by_role("link", name="Runtime control").click()
        notice = page.locator(".notice", has_text="ROS is not running")
        expect(notice).to_be_visible()
        self.start_master(master)
        expect(page.locator(".notice", has_text="The engine is not running")).to_be_visible()
        self.end("master")
        expect(notice).to_be_visible()
        self.start_master(master)
        expect(notice).to_have_count(0)
        self.start("second engine", "flexbe_onboard", "start_behavior", **uri)
        expect(page.locator(".state")).to_have_text("idle")
        expect(page.get_by_role("combobox", name="Behavior")).to_be_disabled()
        self.see_that_the_server_refuses(page)
        self.see_what_an_operator_may(page)
        self.end("second engine", "late")
        self.end("master")

    def start_master(self, port):
        self.processes["master"] = subprocess.Popen(
            ["roscore", "-p", str(port)],
            env=os.environ | {"ROS_MASTER_URI": f"http://127.0.0.1:{port}"},
            stdout=subprocess.DEVNULL,
            start_new_session=True,
        )

    def see_that_the_server_refuses(self, page):
        """A watcher whose browser pretends that a button is enabled gets nowhere."""
        page.goto(page.url.replace("/runtime", "/order_desk"))
        answer = page.evaluate(
            "fetch('/order_desk/file?name=a.csv', {method: 'POST', body: 'x'})"
            ".then(async (answer) => `${answer.status} ${await answer.text()}`)"
        )
        self.assertEqual(answer, "403 A watcher sends no design files; this needs an operator.")
        page.goto(page.url.replace("/order_desk", "/configuration"))
        box = page.get_by_role("checkbox", name="Allow ROS commands")
        expect(box).to_be_disabled()
        box.evaluate(PRETEND)
        self.press(page, "Dark or light")  # handled after what was pretended
        expect(page.locator("body.body--dark")).to_have_count(1)
        lines = map(json.loads, self.record.read_text().splitlines())
        self.assertEqual(
            [(one["command"], one["state"]) for one in lines if one["who"] == "bob"],
            [("sign in", "done")],
        )
        text = self.settings.read_text() if self.settings.exists() else ""
        self.assertNotIn('"are_commands_allowed": false', text)

    def see_what_an_operator_may(self, page):
        """An operator commands the cell, and neither edits nor configures."""
        page.get_by_role("button", name="Sign out").click()
        page.get_by_label("Name").fill("ann")
        page.get_by_label("Password").fill("drive horse")
        page.get_by_role("button", name="Sign in").click()
        expect(page.locator(".bar .user")).to_have_text("ann, operator")
        page.get_by_role("link", name="Runtime control").click()
        expect(page.get_by_role("combobox", name="Behavior")).to_be_enabled()
        self.choose(page, "Behavior", "Errand")
        expect(page.locator(".headline .title")).to_have_text("Errand")
        page.get_by_role("link", name="Editor").click()
        expect(page.get_by_text("read-only")).to_be_visible()
        expect(page.get_by_role("button", name="New")).to_be_disabled()
        commands = [json.loads(line) for line in self.record.read_text().splitlines()]
        self.assertIn(
            ("ann", "load Errand", "done"),
            [(one["who"], one["command"], one["state"]) for one in commands],
        )

    def test_a_tablet_in_the_dark_and_the_keys(self):
        self.load(self.page, "Errand")
        page = self.open_tablet_in_the_dark("/runtime", "li.node")
        self.take_picture(page, "runtime-dark-1024")
        page.keyboard.press("?")
        expect(page.get_by_role("dialog")).to_contain_text("confirm the engine's request")


if __name__ == "__main__":
    rospy.init_node("test_console_restarts")
    rostest.rosrun("remodel_console", "test_console_restarts", ConsoleRestartsTest)
