#!/usr/bin/env python3
"""Runtime control in a real browser, against a real engine and mirror."""

import contextlib
import json
import os
import re
import subprocess
import sys
import threading
import time
from pathlib import Path

import rospy
import rostest
from flexbe_msgs.msg import BehaviorSelection
from playwright.sync_api import expect
from sensor_msgs.msg import Image
from std_msgs.msg import String
from std_srvs.srv import Trigger, TriggerResponse

sys.path.insert(0, str(Path(__file__).parent))
from behavior_test_case import BehaviorTestCase
from fake_cell import FakeCell
from fake_supervisor import FakeRecords, FakeSupervisor

from remodel_console.core.access import Account, Role
from remodel_console.core.answer import DONE, FAILED
from remodel_console.edge.catalogue import Catalogue
from remodel_console.edge.users_file import hash_of, write_accounts
from remodel_console.ros.ask import ask
from remodel_console.testing.browser_test import LIMIT_S, free_port
from remodel_supervision.core.runs.events import Ending, RunEnded

TRUTH_S = 10.0  # in which a page shows that a node has ended; 2 s on idle cores
REPORTED_S = 15.0  # of the recorded run, at which Report is active
LIT_S = 0.1  # within which a transition is seen
SEES_PATROL = """() => !window.isOld && document.querySelector('li.node.active')
  && document.querySelector('.attach')?.textContent.includes("'Patrol' runs unattended.")"""
# Report to a page's server that a disabled box was changed.
PRETEND = """(box) =>
  getElement(box.closest('[id^="c"]').id.slice(1)).$emit('update:model-value', false)"""
OBSERVE = """() => {
  const frame = document.querySelector('.canvas-frame');
  window.lit = [];
  new MutationObserver(() => window.lit.push([Date.now(), frame.dataset.active]))
    .observe(frame, { attributes: true, attributeFilter: ['data-active'] });
}"""


class ConsoleTest(BehaviorTestCase):
    first_page = "/runtime"

    def setUp(self):
        super().setUp()
        self.ready(self.page)

    def tearDown(self):
        """Leave the engine idle for the next test."""
        if self.page.locator(".state.running").count():
            self.stop(self.page)

    def ready(self, page):
        expect(page.locator(".notice", has_text="engine")).to_have_count(0)
        expect(page.locator(".state")).not_to_have_text("no engine")

    def load(self, page, name):
        self.choose(page, "Behavior", name)
        expect(page.locator(".headline .title")).to_have_text(name)
        expect(page.locator("li.node").first).to_be_visible()

    def start_elsewhere(self, name):
        """Start a behavior as a launcher would, unattended."""
        known = Catalogue(self.environment["ROS_PACKAGE_PATH"]).behaviors()
        installed = next(one for one in known if one.name == name)
        publisher = rospy.Publisher("flexbe/start_behavior", BehaviorSelection, queue_size=1)
        self.wait_until(publisher.get_num_connections)
        publisher.publish(
            BehaviorSelection(
                behavior_id=installed.behavior_id,
                behavior_checksum=installed.source_checksum,
                autonomy_level=255,
            )
        )

    def lock(self, page):
        """Lock the active state; again if it was left before the engine had the command."""
        held = page.locator(".held", has_text="Locked:")

        def is_held():
            page.keyboard.press("Alt+l")
            with contextlib.suppress(AssertionError):
                expect(held).to_be_visible(timeout=2000)
            return held.count()

        self.wait_until(is_held)

    def stop(self, page):
        self.press(page, "Stop")
        page.get_by_role("dialog").get_by_role("button", name="Stop", exact=True).click()
        expect(page.locator(".ending")).to_have_text("The last run was stopped.")

    def test_a_behavior_is_started_confirmed_and_ends(self):
        self.load(self.page, "Errand")
        self.choose(self.page, "Autonomy", "Low")
        self.page.get_by_label("greeting").fill("good morning")
        self.press(self.page, "Start")
        expect(self.page.locator(".request")).to_contain_text("Leave 'Report' with 'done'?")
        expect(self.page.locator("li.node.asked[data-path='Report']").first).to_be_visible()
        expect(self.page.locator("li.node.passed[data-path='Search/Look']").first).to_be_visible()
        expect(self.page.locator(".log")).to_contain_text("The errand says good morning.")
        self.log_is_filtered()
        self.page.get_by_text("Userdata").click()
        self.press(self.page, "Read")
        expect(self.page.locator("table.plain")).to_contain_text("good morning")
        self.take_picture(self.page, "runtime-request")
        self.page.keyboard.press("Alt+c")
        expect(self.page.locator(".ending")).to_have_text("The last run ended with 'finished'.")
        commands = [json.loads(line) for line in self.record.read_text().splitlines()]
        given = [(c["who"], c["command"], c["state"]) for c in commands]
        self.assertIn(("operator", "confirm 'done' of /Report", "done"), given)
        self.assertTrue(any("greeting=good morning" in command for _, command, _ in given))

    def log_is_filtered(self):
        """Find lines by severity and by words; what does not fit is not shown, and comes back."""
        lines = self.page.locator(".log .line:visible")
        hint = self.page.locator(".log .line.hint", has_text="The errand says")
        every = lines.count()
        self.press(self.page, "hint")
        expect(hint.first).to_be_hidden()
        expect(self.page.locator(".log .line.info:visible").first).to_be_visible()
        self.press(self.page, "hint")
        self.press(self.page, "info")
        expect(hint.first).to_be_visible()
        expect(self.page.locator(".log .line.info:visible")).to_have_count(0)
        find = self.page.get_by_label("Find in the log")
        find.fill("GOOD morning")
        expect(lines).to_have_count(hint.filter(has_text="good morning").count())
        find.fill("no such line")
        expect(lines).to_have_count(0)
        expect(self.page.locator(".log-tools .soft")).to_contain_text("0 of ")
        find.fill("")
        self.press(self.page, "info")
        self.wait_until(lambda: lines.count() >= every, "all lines")

    def test_breakpoints_stop_states_also_beside_others_and_values_stand_at_them(self):
        page = self.page
        self.load(page, "Twins")
        self.addCleanup(rospy.set_param, "/flexbe/breakpoints", [])
        for state in ("Both/Second", "Greet"):
            self.pick_drawn(page, state)
            expect(self.state_panel(page).get_by_label("State")).to_have_value(
                state.replace("/", " / ")
            )
            self.press(page, "Breakpoint")
            expect(page.locator(f"li.stopping[data-path='{state}']")).to_have_count(1)
        self.assertEqual(rospy.get_param("/flexbe/breakpoints"), ["/Both/Second", "/Greet"])
        expect(page.locator(".state-hint")).to_contain_text("Breakpoints act in supervised")
        page.mouse.click(*self.empty_place(page))
        self.choose(page, "Autonomy", "Full")
        page.get_by_label("greeting").fill("good evening")
        self.press(page, "Start")
        expect(page.locator(".request")).to_contain_text("Leave 'Second' with 'done'?")
        expect(page.locator(".request")).to_have_count(1)
        expect(page.locator(".state-hint")).to_be_hidden()
        other = self.open_page()
        expect(other.locator(".request")).to_contain_text("Leave 'Second' with 'done'?")
        expect(other.locator("li.stopping")).to_have_count(2)
        page.keyboard.press("Alt+c")
        expect(page.locator(".request")).to_contain_text("Leave 'Greet' with 'done'?")
        expect(page.locator(".canvas-values[data-path='Greet']")).to_have_text("datagood evening")
        expect(page.locator(".state-panel table")).to_contain_text("good evening")
        expect(page.locator(".state-panel table th")).to_have_text(["Key", "On entry", "On exit"])
        self.take_picture(page, "runtime-breakpoint")
        self.press(other, "Remove all 2")
        expect(page.locator(".ending")).to_have_text("The last run ended with 'finished'.")
        expect(page.locator(".request")).to_have_count(0)
        expect(page.locator("li.stopping")).to_have_count(0)
        expect(page.locator(".canvas-values")).to_be_hidden()
        self.assertEqual(rospy.get_param("/flexbe/breakpoints"), [])
        commands = [json.loads(line)["command"] for line in self.record.read_text().splitlines()]
        for command in ("set a breakpoint at Both / Second", "remove all breakpoints"):
            self.assertIn(command, commands)

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

    def state_panel(self, page):
        return page.get_by_role("region", name="State")

    def empty_place(self, page):
        box = page.locator(".canvas-stage").bounding_box()
        return box["x"] + 8, box["y"] + 8

    def test_attaching_to_what_another_client_has_started(self):
        self.load(self.page, "Errand")
        self.start_elsewhere("Patrol")
        expect(self.page.locator(".attach")).to_contain_text("'Patrol' runs unattended.")
        late = self.open_page()
        expect(late.locator(".attach")).to_contain_text("Load 'Patrol' first: 'Errand' is loaded.")
        expect(late.locator("li.node.active")).not_to_have_count(
            0
        )  # what runs is drawn, not Errand
        self.take_picture(late, "runtime-attach")
        self.press(late, "Load 'Patrol'")
        expect(self.page.locator("li.node.active")).not_to_have_count(0)
        self.press(self.page, "Attach")
        for page in (self.page, late):
            expect(page.get_by_role("button", name="Pause", exact=True)).to_be_visible()
        self.press(late, "Pause")
        expect(self.page.locator(".state")).to_have_text("paused")
        self.page.reload()
        expect(self.page.locator(".state")).to_have_text("paused")
        expect(self.page.locator("li.node.active")).not_to_have_count(0)
        self.press(self.page, "Continue")
        expect(late.locator(".state")).to_have_text("running")
        self.lock(late)
        expect(self.page.locator(".held")).to_be_visible()
        self.press(self.page, "Unlock")
        expect(late.locator(".held")).to_have_count(0)
        self.press(late, "Repeat")
        self.stop(self.page)
        expect(late.locator(".ending")).to_have_text("The last run was stopped.")

    def test_what_runs_goes_on_in_the_version_that_was_saved_meanwhile(self):
        self.load(self.page, "Patrol")
        self.choose(self.page, "Autonomy", "Low")
        self.press(self.page, "Start")
        expect(self.page.get_by_role("button", name="Lock", exact=True)).to_be_visible()
        self.lock(self.page)
        held = self.page.locator(".held").inner_text()
        editor = self.open_page("/editor")
        self.choose(editor, "Open", "Patrol")
        self.pick_drawn(editor, "North")
        field = editor.locator(".properties").get_by_label("wait_time", exact=True)
        field.fill("0.33")
        field.press("Enter")
        expect(editor.locator(".tools")).to_contain_text("not saved yet")
        self.press(editor, "Save")
        expect(self.page.get_by_text("Another version of 'Patrol' is saved.")).to_be_visible()
        self.press(self.page, "Switch")
        expect(self.page.get_by_text("Another version of 'Patrol' is saved.")).to_have_count(0)
        expect(self.page.locator(".held")).to_have_text(held)
        self.press(self.page, "Unlock")
        expect(self.page.locator(".held")).to_have_count(0)
        expect(self.page.locator("li.node.active")).not_to_have_count(0)
        field.fill("0.34")
        field.press("Enter")
        self.press(editor, "Save")
        expect(self.page.get_by_text("Another version of 'Patrol' is saved.")).to_be_visible()
        for command in ("switch", "unlock"):
            answer = ask(command, "", LIMIT_S)
            self.assertEqual(answer.state, DONE, answer)
        self.assertEqual(ask("switch", "", LIMIT_S).state, FAILED)
        self.stop(self.page)
        self.assertIn("switch to the saved version of 'Patrol'", self.record.read_text())

    def test_an_outcome_is_forced(self):
        self.load(self.page, "Errand")
        self.choose(self.page, "Autonomy", "Low")
        self.press(self.page, "Start")
        expect(self.page.locator(".request")).to_be_visible()
        self.page.locator(".outcomes").get_by_role("button", name="done", exact=True).click()
        expect(self.page.locator(".ending")).to_have_text("The last run ended with 'finished'.")
        self.assertIn("force 'done' of /Report", self.record.read_text())

    def test_a_transition_is_lit_within_a_tenth_of_a_second(self):
        self.load(self.page, "Patrol")
        self.page.evaluate(OBSERVE)
        entered = []
        subscriber = rospy.Subscriber(
            "flexbe/behavior_update",
            String,
            lambda m: entered.append((1000 * time.time(), m.data.rpartition("/")[2])),
            tcp_nodelay=True,
        )
        self.addCleanup(subscriber.unregister)
        self.press(self.page, "Start")

        def late_s() -> list[float]:
            # The page may get an update before this process does.
            lit = self.page.evaluate("() => window.lit")
            apart_ms = [
                [abs(seen_ms - at) for at, label in entered if label == path]
                for seen_ms, path in lit
            ]
            return sorted(min(each) / 1000 for each in apart_ms if each)

        self.wait_until(lambda: len(entered) >= 16 and len(late_s()) > 5)
        late = late_s()
        self.assertLess(late[len(late) // 4], LIT_S, late)  # a busy machine delays many

    def test_what_is_killed_is_shown_and_found_again(self):
        self.load(self.page, "Patrol")
        self.press(self.page, "Start")
        expect(self.page.locator("li.node.active")).not_to_have_count(0)
        self.kill("engine")
        notice = self.page.locator(".notice", has_text="The engine is not running")
        expect(notice).to_be_visible(timeout=1000 * TRUTH_S)
        expect(self.page.locator("li.node.active")).to_have_count(0)
        self.take_picture(self.page, "runtime-engine-away")
        self.start_engine()
        expect(notice).to_have_count(0)
        expect(self.page.locator(".state")).to_have_text("idle")
        self.press(self.page, "Start")
        expect(self.page.locator("li.node.active")).not_to_have_count(0)
        self.kill("mirror")
        expect(self.page.locator(".notice", has_text="The mirror is not running")).to_be_visible(
            timeout=1000 * TRUTH_S
        )
        self.start_mirror()
        expect(self.page.locator(".notice", has_text="mirror")).to_have_count(0)
        self.page.evaluate("() => { window.isOld = true; }")
        self.kill("console")
        away = self.page.get_by_text("The console is not running:")
        expect(away).to_be_visible(timeout=1000 * TRUTH_S)
        self.take_picture(self.page, "runtime-console-away")
        self.start_console()
        self.page.wait_for_function(SEES_PATROL)

    def test_a_console_that_restarts_finds_what_waits_for_an_operator(self):
        self.load(self.page, "Errand")
        self.choose(self.page, "Autonomy", "Low")
        self.press(self.page, "Start")
        expect(self.page.locator(".request")).to_be_visible()
        self.page.evaluate("() => { window.isOld = true; }")
        self.kill("console")
        self.start_console()
        self.page.wait_for_function("() => !window.isOld")
        expect(self.page.get_by_role("combobox", name="Autonomy")).to_have_value("Low")
        expect(self.page.locator(".log")).to_contain_text("The errand says hello.")
        expect(self.page.locator(".request")).to_contain_text("Leave 'Report' with 'done'?")
        self.page.keyboard.press("Alt+c")
        expect(self.page.locator(".ending")).to_have_text("The last run ended with 'finished'.")

    def start_master(self, port):
        self.processes["master"] = subprocess.Popen(
            ["roscore", "-p", str(port)],
            env=os.environ | {"ROS_MASTER_URI": f"http://127.0.0.1:{port}"},
            stdout=subprocess.DEVNULL,
            start_new_session=True,
        )

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
    rospy.init_node("test_console")
    rostest.rosrun("remodel_console", "test_console", ConsoleTest)
