#!/usr/bin/env python3
"""Ctrl-C of a whole launch loses nothing, and a cell has one station at a time."""

import shutil
import sys
import unittest
from pathlib import Path

import rostest
from order_client import import_order, wait_until
from own_launch import OwnLaunch

from remodel_production.edge.database.cell_ownership import live_owners
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_states.testing.world import Deed, account
from remodel_states.testing.world_file import WorldFile
from remodel_supervision.core.runs.events import Blocked, Ending, Interrupted, RunEnded
from remodel_supervision.edge.run_log import RunLog

OUTPUT = Path(sys.argv[1])
LAUNCH = Path(__file__).parent / "station.launch"


class StationsTest(unittest.TestCase):
    def setUp(self):
        self.folder = OUTPUT / self.id().rpartition(".")[2]
        self.folder.mkdir(parents=True)
        self.addCleanup(shutil.rmtree, OUTPUT, ignore_errors=True)
        self.url = f"sqlite:///{self.folder}/production.sqlite"
        import_order(self.url)
        self.database = ProductionDatabase(self.url)
        self.addCleanup(self.database.close)
        self.log = RunLog(self.database)

    def station(self, name):
        """Start a station with a cell of its own; all have the same database."""
        folder = self.folder / name
        launch = OwnLaunch(LAUNCH, folder, output=folder, database=self.url)
        self.addCleanup(launch.interrupt)
        return launch

    def order(self, launch, *options, name="order.log"):
        process = launch.order(self.url, *options, name=name)

        def end():
            process.kill()
            process.wait()

        self.addCleanup(end)
        return process

    def fixed(self, name):
        """Return how many ends a station has fixed."""
        return sum(entry.deed is Deed.FIX for entry in self.ledger(name))

    def ledger(self, name):
        file = self.folder / name / "world.sqlite"
        return WorldFile(file).ledger() if file.is_file() else ()

    def events(self, run):
        return [kept.event for kept in self.log.events(run)]

    def assert_complete(self, run, name):
        wait_until(lambda: self.log.state(run).ended is not None, f"the end of run {run}")
        state = self.log.state(run)
        self.assertEqual(state.ended.ending, Ending.COMPLETE, state.ended)
        found = account(self.ledger(name), list(state.tasks))
        self.assertEqual((found.fixed_again, found.scrapped, found.omitted), ((), (), ()))

    def test_an_order_goes_on_after_its_launch_was_interrupted_and_started_again(self):
        first = self.station("a")
        self.order(first, "--wires", "4")
        wait_until(lambda: self.fixed("a") > 2, "the second wire is under way")
        (head,) = self.log.heads()
        first.interrupt()
        events = self.events(head.number)
        kinds = (Blocked, RunEnded, Interrupted)
        self.assertEqual([event for event in events if isinstance(event, kinds)], [])
        self.assertEqual(live_owners(self.database), (), "the cell is released")
        second = self.station("a")
        self.assert_complete(head.number, "a")
        second.interrupt()
        later = self.events(head.number)[len(events) :]
        self.assertIsInstance(later[0], Interrupted)
        self.assertEqual(sum(isinstance(event, Interrupted) for event in later), 1)

    def test_a_second_station_of_one_name_is_refused_until_the_first_has_ended(self):
        first, second = self.station("a"), self.station("b")
        wait_until(lambda: live_owners(self.database), "a station owns the cell")
        owner, other = (first, second) if self.is_owner(first) else (second, first)
        name = "a" if owner is first else "b"
        self.order(owner, "--wires", "4")
        wait_until(lambda: self.fixed(name) > 0, "the first wire is under way")
        (head,) = self.log.heads()
        refused = self.order(other, "--wires", "2", "--again")
        self.assertEqual(refused.wait(240.0), 3, other.printed())
        self.assertIn("cell cell is owned by another station", other.printed())
        self.assertIn(owner.master, other.printed())
        self.assert_complete(head.number, name)
        self.assertEqual([each.number for each in self.log.heads()], [head.number])
        self.assertEqual(self.ledger("b" if name == "a" else "a"), ())
        owner.interrupt()
        taken = self.order(other, "--wires", "2", "--again", name="again.log")
        self.assertEqual(taken.wait(240.0), 0, other.printed("again.log"))

    def is_owner(self, launch):
        (owner,) = live_owners(self.database)
        return launch.master in owner.holder


if __name__ == "__main__":
    rostest.rosrun("remodel_planner", "test_stations", StationsTest)
