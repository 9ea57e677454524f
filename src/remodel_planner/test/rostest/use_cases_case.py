"""What the tests of use cases share: their designs, and orders of these over a fake cell."""

import shutil
import sys
import unittest
from pathlib import Path

import rospy
import yaml
from order_client import DESIGN, planner

from remodel_tasks.edge.use_case_files import use_case_folder

OUTPUT = Path(sys.argv[1])
DATABASE = f"sqlite:///{OUTPUT}/production.sqlite"
DESIGNS = Path(__file__).parents[3] / "remodel_production/test/unit/designs"
HARNESS = Path(__file__).parents[3] / "remodel_tasks/examples/harness.yml"

# A design for each shipped use case, and how many of its wires are asked for.
SHIPPED = {
    "cabinet": (DESIGN, 3),
    "harness_formboard": (HARNESS, 3),
    "automotive_formboard": (DESIGNS / "loom.kbl", 2),
    "medical_hoses": (DESIGNS / "harness.yml", 3),
}


class UseCasesCase(unittest.TestCase):
    """Runs orders by use cases, of which `own_cabinet` is a user's own."""

    @classmethod
    def setUpClass(cls):
        rospy.init_node("test_use_cases")
        cls.addClassCleanup(shutil.rmtree, OUTPUT, ignore_errors=True)
        # A user's own: a folder outside the workspace, which REMODEL_USE_CASES names.
        (OUTPUT / "use_cases").mkdir(parents=True)
        cls.add_own("own_cabinet", lambda own: own.update(title="Hang Wire {task}"))

    @staticmethod
    def add_own(name, change):
        own = yaml.safe_load((use_case_folder() / "cabinet.yaml").read_text())
        del own["designs"]["default_for"]
        own["name"] = name
        change(own)
        (OUTPUT / f"use_cases/{name}.yaml").write_text(yaml.safe_dump(own))

    def add_order(self, name, design=DESIGN):
        imported = planner("import", str(design), "--order", name, database=DATABASE)
        self.assertEqual(imported.returncode, 0, imported.stderr)

    def line(self, order, use_case, tasks):
        options = ("--use-case", use_case, "--wires", str(tasks), "--output", str(OUTPUT / order))
        return ("run", order, *options)

    def carries_its_order_out(self, name):
        self.carries_out(name, name, *SHIPPED[name])

    def carries_out(self, name, use_case, design, wires):
        self.add_order(name, design)
        ran = planner(*self.line(name, use_case, wires), database=DATABASE)
        self.assertEqual(ran.returncode, 0, ran.stdout + ran.stderr)
        self.assertIn(f"order {name}, use case {use_case}, ", ran.stdout)
        whole = f"{wires} of {wires} wires placed, {wires} without a failed operation"
        self.assertIn(whole, ran.stdout)
