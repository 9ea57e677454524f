#!/usr/bin/env python3
"""Two people prepare an order with preferences at the order desk, and it is run by these."""

import rospy
import rostest
from order_client import OrderClient
from order_desk_case import DATABASE, OUTPUT, WORK_MS, OrderDeskCase
from playwright.sync_api import expect

from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_production.errors import OrderError
from remodel_supervision.core.runs.events import Ending, TaskBegun

MARKUP = "<img src=x onerror='document.title=1'>"
OWN_HEADINGS = f"aaa;bbb;ccc;ddd;eee\nK1:1;X1:1;1;W1;0.6\nK1:2;X1:2;1;{MARKUP};0.6\n"
MEANINGS = {
    "aaa": "First end: component and terminal",
    "bbb": "Second end: component and terminal",
    "ccc": "Section",
    "ddd": "Wire",
    "eee": "Length",
}
MIDDLE = """(line) => {
  line.scrollIntoView({ block: "center" });
  const at = line.getPointAtLength(line.getTotalLength() / 2).matrixTransform(line.getScreenCTM());
  return [at.x, at.y];
}"""
LIST = """Wire,From,To,Section mm2,Colour,Shelf,Length mm
W1,K1:1,X1:1,1,BU,a,600
W2,K1:2,X1:2,1,BK,b,600
W3,K1:3,X1:3,400,BK,c,600
W4,K1:4,X1:4,1,RD,d,600
"""


class OrderDeskPreferencesTest(OrderDeskCase):
    def test_a_list_becomes_an_order_that_is_run_by_its_preferences(self):
        page = self.page
        self.drop("loom.csv", LIST)
        area = page.locator(".desk-area")
        expect(area).to_contain_text("2 components, 4 wires")
        expect(area).to_contain_text("column 'Shelf' is not used: its heading is not known")
        expect(area.locator(".by-hand")).to_contain_text("W3")
        expect(area.locator(".by-hand")).to_contain_text(
            "characteristics.task.section_mm2 in cabinet.yaml"
        )
        page.get_by_text("Assumptions (").click()
        expect(area).to_contain_text("insertion force limit not given, 40 N taken")
        expect(area.locator(".plan-words")).to_contain_text("3 tasks in")
        expect(area.locator(".plot path").first).to_be_attached()
        board = page.get_by_role("img", name="The board")
        self.assertGreater(board.evaluate("(img) => img.naturalWidth"), 0)
        with self.assertRaises(OrderError):  # nothing is stored before a person says so
            ProductionDatabase(DATABASE).order("loom")
        self.contradict()
        self.work_together()
        page.reload()  # what is not stored is not lost
        expect(page.locator(".preference", has_text="red first")).to_be_visible()
        expect(page.locator(".preference", has_text="black late")).to_be_visible()
        self.start_order()

    def contradict(self):
        """Two requirements contradict, and both are named; without one of them there is a plan."""
        page = self.page
        route = "Required: Route some wires below others"
        self.add_entry(page, route, "up", route="W1", before="W2")
        expect(page.locator(".held", has_text="have changed since")).to_be_visible()
        self.add_entry(page, route, "down", route="W2", before="W1")
        self.plan_again()
        expect(page.locator(".ending.bad")).to_contain_text("There is no plan.")
        expect(page.locator(".conflicting li")).to_have_count(2)
        expect(page.locator(".preference.conflict")).to_have_count(2)
        expect(page.locator(".plan-words")).to_have_count(0)
        self.press(page, "Add an entry")
        dialog = page.get_by_role("dialog")
        dialog.get_by_label("Name", exact=True).fill("broken")
        dialog.get_by_label("pick", exact=True).fill("{colour: ")
        self.press(dialog, "Add")
        expect(dialog.get_by_role("alert")).to_contain_text("pick: line 1: is no YAML")
        self.press(dialog, "Cancel")
        self.press(page, "Remove up")
        self.plan_again()
        expect(page.locator(".preference.conflict")).to_have_count(0)
        expect(page.locator(".plan-words")).to_contain_text("3 tasks in")

    def work_together(self):
        """Two people see the same draft; nobody's change is lost by the other's."""
        page, other = self.page, self.open_page(self.page.url.partition(str(self.port))[2])
        expect(other.locator(".preference")).to_have_count(1)
        self.press(page, "Edit all as YAML")
        first = page.get_by_role("dialog").get_by_label("YAML", exact=True)
        expect(first).to_have_value(r"""format: remodel-preferences-1
require:
  - {name: down, route: W2, before: W1}
""")
        prefer = "Preferred: Pick some wires before others"
        self.add_entry(other, prefer, "red first", pick="{colour: RD}", before="all", weight="300")
        first.fill("format: remodel-preferences-1")
        self.press(page.get_by_role("dialog"), "Save")
        expect(page.locator(".q-notification")).to_contain_text("another person has changed")
        self.press(page, "OK")
        self.press(page.get_by_role("dialog"), "Cancel")
        expect(page.locator(".preference", has_text="red first")).to_be_visible()
        self.click_entry()
        expect(other.locator(".preference", has_text="black late")).to_be_visible()
        self.plan_again()
        page.get_by_text("Explanation:").click()
        expect(page.locator(".explanation")).to_contain_text("black late")
        page.get_by_text("Tasks in their order").click()
        self.assertEqual(self.planned(), ["W4", "W2", "W1"])
        black = "black late: W1 should be picked before W2"
        expect(page.locator("details tr", has_text="W1").last).to_contain_text(black)
        expect(page.locator(".violated")).to_have_text("Violated: W1 should be picked before W2")
        page.locator(".order-desk").evaluate("(desk) => desk.scrollTo(0, 0)")
        page.set_viewport_size({"width": 1280, "height": 1500})
        self.take_picture(page, "order-desk")

    def middle_of(self, line):
        """Return where the middle of a line is on the page, once the dialog moves no more."""
        places = []

        def is_still():
            places.append(line.evaluate(MIDDLE))
            return places[-2:-1] == places[-1:]

        self.wait_until(is_still, "the dialog to be still")
        return places[-1]

    def click_entry(self):
        """Wires are filled in by clicks: on the board, on their terminals, and on their rows."""
        page = self.page
        self.press(page, "Add an entry")
        dialog = page.get_by_role("dialog")
        dialog.get_by_label("Name", exact=True).fill("black late")
        pick, before = (dialog.get_by_label(each, exact=True) for each in ("pick", "before"))
        wire = dialog.locator("[data-wire='W1']")
        for text, is_chosen in (("[W1]", True), ("", False)):
            page.mouse.click(*self.middle_of(wire.locator(".area")))
            expect(pick).to_have_value(text)
            expect(dialog.locator(".chosen[data-wire='W1']")).to_have_count(int(is_chosen))
        dialog.get_by_text("Wires (4)").click()
        row = dialog.get_by_role("button", name="W1: ")
        row.click()
        expect(pick).to_have_value("[W1]")
        expect(row).to_have_attribute("aria-pressed", "true")
        dialog.get_by_role("button", name="W3: ").click()
        expect(dialog.get_by_role("alert")).to_contain_text("W3 is by hand: ")
        expect(pick).to_have_value("[W1]")
        before.fill("{colour: BK}")
        terminal = dialog.locator("[data-terminal='K1:2']")
        terminal.click(force=True)  # its wire is drawn over it
        expect(dialog.get_by_role("alert")).to_contain_text("before: `{colour: BK}` is no list")
        before.fill("")
        terminal.click(force=True)
        expect(before).to_have_value("[W2]")
        expect(dialog.locator(".chosen")).to_have_attribute("data-wire", "W2")
        dialog.get_by_label("weight", exact=True).fill("1")
        self.press(dialog, "Add")
        expect(dialog).to_have_count(0)

    def start_order(self):
        page = self.page
        page.get_by_label("Name of the order").fill("our loom")
        self.press(page, "Start the order")
        page.wait_for_url("**/overview", timeout=WORK_MS)
        expect(page.locator(".ending")).to_contain_text("Order 'our loom'", timeout=WORK_MS)
        expect(page.locator(".ending")).to_contain_text("are done")
        self.assertIn(("run order 'our loom', use case cabinet", "done"), self.recorded())
        orders = OrderClient(OUTPUT)
        number = orders.runs()[0]
        run = orders.run_state(number)
        self.assertEqual(run.ended.ending, Ending.COMPLETE)
        begun = [each.task for each in orders.events(number) if isinstance(each, TaskBegun)]
        self.assertEqual(begun, ["W4", "W2", "W1"])  # as planned, by the preferences
        self.assertEqual(
            ProductionDatabase(DATABASE).preferences("our loom")["require"][0]["name"], "down"
        )

    def add_entry(self, page, what, name, **fields):
        self.press(page, "Add an entry")
        dialog = page.get_by_role("dialog")
        dialog.get_by_role("combobox", name="What").click()
        page.get_by_role("option", name=what).click()
        dialog.get_by_label("Name", exact=True).fill(name)
        for field, text in fields.items():
            dialog.get_by_label(field, exact=True).fill(text)
        self.press(dialog, "Add")
        expect(dialog).to_have_count(0)

    def plan_again(self):
        self.press(self.page, "Plan again")
        expect(self.page.get_by_role("button", name="Plan again")).to_have_count(0, timeout=WORK_MS)
        expect(self.page.locator(".doing")).to_be_hidden(timeout=WORK_MS)

    def test_a_file_is_refused_with_the_commands_own_words_and_a_mapping_helps(self):
        page = self.page
        self.drop("own.csv", OWN_HEADINGS)
        refused = page.locator(".desk-area .ending.bad")
        expect(refused).to_contain_text("own.csv: line 1: 'aaa;bbb;ccc;ddd;eee' begins no format")
        self.assertEqual(self.recorded()[-1], ("import own.csv", "failed"))
        expect(page.get_by_role("button", name="Start the order")).to_have_count(0)
        expect(page.locator("table.columns tr").nth(1)).to_contain_text("K1:1")
        read = "Read the file by these columns"
        for heading, meaning in {"aaa": "Wire", "bbb": "Wire"}.items():
            self.choose(page, heading, meaning)
        self.press(page, read)
        expect(page.get_by_role("alert").last).to_contain_text("'aaa' and 'bbb' are both 'Wire'")
        for heading, meaning in MEANINGS.items():
            self.choose(page, heading, meaning)
        self.choose(page, "Lengths without a unit", "m")
        self.take_picture(page, "columns")
        self.press(page, read)
        expect(page.locator(".plan-words")).to_contain_text("2 tasks in", timeout=WORK_MS)
        expect(refused).to_have_count(0)
        page.get_by_text("Tasks in their order").click()
        self.assertEqual(set(self.planned()), {"W1", MARKUP})
        self.assertIn("Order desk", page.title())
        self.press(page, "Columns")  # of a list that was read, to be corrected
        expect(page.locator("table.columns")).to_contain_text("eee")
        self.press(page, "Remove own.csv")
        self.press(page.get_by_role("dialog"), "Remove")
        expect(page.locator(".draft")).to_have_count(0)
        expect(page.locator(".desk-area .card")).to_have_count(0)


if __name__ == "__main__":
    rospy.init_node("test_order_desk_preferences")
    rostest.rosrun("remodel_planner", "test_order_desk_preferences", OrderDeskPreferencesTest)
