#!/usr/bin/env python3
"""A cabinet that the simulated cell remembers, read back from its physics for the report.

The wires were put where they are without a robot: right, turned round beside a duct, in a wrong
terminal, hanging loose.
"""

import shutil
import sys
import unittest
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import rospy
import rostest
from order_client import DESIGN, planner
from remodel_msgs.srv import LoadPanel

from remodel_planner.commands.options.problem_files import design_order
from remodel_planner.commands.runs.order_report import picture_of_cabinet, wires_in_cell
from remodel_planner.core.net_list import net_list, share_in_ducts
from remodel_production.core.board.board import board_of
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_production.edge.design_files import catalogue_file, read_catalogue
from remodel_skills.edge.cell_memory import CellMemory
from remodel_states.edge.exported_tables import read_wire_materials
from remodel_supervision.ros.peers.board_message import board_message
from remodel_tasks.core.orders.board_order import board_order
from remodel_work.panel import BOARD, WireEnd
from remodel_work.ros.panel_message import panel_from
from remodel_work.routes import ParkedWire, PlacedWires

MEMORY = Path(sys.argv[1])
LIMIT_S = 60.0
BELOW_M, ABOVE_M, BETWEEN_M = 0.020, 0.065, 0.005


def bottom(panel, key):
    """Return the bottom of a terminal (3,) [m] in the world."""
    depth = panel.component(key[0]).terminal(key[1]).depth
    return (BOARD @ panel.panel_from_socket(*key)).apply(np.array([depth, 0.0, 0.0]))


def lying(panel, wire_id, *, height, ends, fixed=tuple(WireEnd)):
    """Return a wire along its route at a height [m], its tips in terminals; None: beside them."""
    route = [BOARD.apply(np.array(at)) for at in panel.wire(wire_id).route]
    legs = []
    for a, b in pairwise(route):
        leg = np.linspace(a, b, round(np.linalg.norm(b - a) / BETWEEN_M), endpoint=False)
        leg[:, 2] = height
        legs.append(leg)
    first, last = (bottom(panel, key)[None] if key else np.empty((0, 3)) for key in ends)
    return ParkedWire(np.concatenate([first, *legs, last]), frozenset(fixed))


class BuiltInCellTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("test_built_in_cell")
        MEMORY.mkdir(exist_ok=True)
        cls.addClassCleanup(shutil.rmtree, MEMORY)
        database = f"sqlite:///{MEMORY}/production.sqlite"
        imported = planner("import", str(DESIGN), "--order", "house", database=database)
        assert imported.returncode == 0, imported.stderr
        cls.order = ProductionDatabase(database).order("house").in_cabinet()
        options = SimpleNamespace(use_case="cabinet", cell="two_arms_cabinet", arms=1)
        design = design_order(cls.order, options)
        board = board_of(cls.order, read_catalogue(catalogue_file()))
        whole = board_order(board, design.use_case, arms=1)
        by_hand = design.work.wires_by_hand
        message = board_message(design.panel, whole, by_hand)
        cls.robots_wires = [wire for wire in cls.order.wires if wire.name not in by_hand]
        load = rospy.ServiceProxy("cell/load_panel", LoadPanel)
        load.wait_for_service(LIMIT_S)  # a cell that starts writes its memory, too
        cls.names = cls.remembered(message)
        loaded = load(panel=message, keep=True)
        assert loaded.success, loaded.message

    @classmethod
    def remembered(cls, message):
        """Have the cell remember four wires of a panel; return their names."""
        panel = panel_from(message, read_wire_materials())
        right, turned, wrong, loose = (wire.id for wire in panel.wires[:4])

        def own(name):
            return [panel.wire(name).goes_to(end) for end in WireEnd]

        wires = {
            right: lying(panel, right, height=BELOW_M, ends=own(right)),
            turned: lying(panel, turned, height=ABOVE_M, ends=own(turned)[::-1]),
            wrong: lying(
                panel, wrong, height=BELOW_M, ends=[own(wrong)[0], own(panel.wires[5].id)[1]]
            ),
            loose: lying(
                panel, loose, height=BELOW_M, ends=[own(loose)[0], None], fixed=[WireEnd.A]
            ),
        }
        memory = CellMemory(MEMORY)
        memory.keep(panel, PlacedWires(wires))
        memory.close()
        return right, turned, wrong, loose

    def nets(self):
        found, unread = wires_in_cell(self.order)
        self.assertEqual(unread, "")
        asked = [wire.name for wire in self.robots_wires[:6]]
        return {net.wire: net for net in net_list(self.order.wires, asked, found)}

    def test_each_wire_is_compared_with_the_design(self):
        nets = self.nets()
        right, turned, wrong, loose = (nets[name] for name in self.names)
        verdicts = [net.verdict.value for net in (right, turned, wrong, loose)]
        self.assertEqual(verdicts, ["as designed", "as designed", "wrong", "missing"])
        sixth = self.robots_wires[5]
        self.assertEqual(wrong.difference, f"in {sixth.b} instead of {wrong.designed[1]}")
        self.assertEqual(loose.difference, f"no end in {loose.designed[1]}")
        self.assertEqual(nets[sixth.name].difference, "no piece of it in the cell")
        self.assertEqual(list(nets), [wire.name for wire in self.robots_wires[:6]])

    def test_the_route_of_each_wire_is_judged_by_where_it_lies(self):
        nets = self.nets()
        right, turned, wrong, _ = (nets[name].found for name in self.names)
        self.assertEqual([wire.in_ducts for wire in (right, turned, wrong)], [1.0, 0.0, 1.0])
        self.assertGreater(min(wire.duct_length_m for wire in (right, turned, wrong)), 0.02)
        within = right.duct_length_m / (right.duct_length_m + turned.duct_length_m)
        both = [nets[name] for name in self.names[:2]]
        self.assertAlmostEqual(share_in_ducts(both), within)

    def test_the_cabinet_is_photographed_from_above(self):
        (picture,) = picture_of_cabinet()
        self.assertTrue(picture.uri.startswith("data:image/jpeg;base64,"))
        self.assertGreater(len(picture.uri), 20_000)


if __name__ == "__main__":
    rostest.rosrun("remodel_planner", "test_built_in_cell", BuiltInCellTest)
