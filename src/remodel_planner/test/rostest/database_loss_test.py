#!/usr/bin/env python3
"""A run whose database is deleted or emptied stops in words, and a backup can take its place."""

import os
import shutil
import sqlite3
import sys
import time
import unittest
from contextlib import closing
from pathlib import Path

import rospy
import rostest
from motion_watch import MotionWatch
from order_client import (
    SUPERVISOR,
    OrderClient,
    import_order,
    planner,
    wait_until,
)
from remodel_msgs.msg import UseCaseState
from rosgraph_msgs.msg import Log

from remodel_supervision.core.runs.events import Ending

OUTPUT = Path(sys.argv[1])
DATABASE = OUTPUT / "production.sqlite"
BACKUP = OUTPUT / "backup.sqlite"

# [s] wall time for which nothing may move, nor be logged, any more.
WINDOW_S = 2.0


def delete():
    """Delete the database and what SQLite keeps beside it."""
    for path in OUTPUT.glob("production.sqlite*"):
        path.unlink()


def empty():
    """Empty the database, once its log has nothing that would restore it."""
    with closing(sqlite3.connect(DATABASE)) as connection:
        connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        os.truncate(DATABASE, 0)


class DatabaseLossTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        rospy.init_node("test_database_loss")
        OUTPUT.mkdir(exist_ok=True)
        cls.addClassCleanup(shutil.rmtree, OUTPUT, ignore_errors=True)
        import_order(f"sqlite:///{DATABASE}")
        saved = planner("backup", str(BACKUP), database=f"sqlite:///{DATABASE}")
        assert saved.returncode == 0, saved.stderr
        cls.orders = OrderClient(OUTPUT)
        cls.motions = MotionWatch(cls.orders.world)
        cls.errors = []
        rospy.Subscriber("/rosout", Log, cls.on_log)

    def is_restored(self):
        """Return whether a backup is put in place, which a live lease on the cell prevents."""
        line = ("restore", str(BACKUP), "--replace")
        done = planner(*line, database=f"sqlite:///{DATABASE}")
        self.assertIn(done.returncode, (0, 1), done.stderr)
        return done.returncode == 0

    @classmethod
    def on_log(cls, log):
        if log.name == f"/{SUPERVISOR}" and log.level >= Log.ERROR:
            cls.errors.append(log.msg)

    def lose(self, damage, words):
        """Damage the database during a run, check what is published, and put a backup back."""
        self.orders.start(3)
        wait_until(lambda: self.motions.running, "an ability has a goal")
        self.errors.clear()
        damage()
        self.orders.wait_for_phase(UseCaseState.STARTING)
        self.assertIn(words, self.orders.state.message)
        self.assertIn("restore a backup", self.orders.state.message)
        wait_until(lambda: not self.motions.running, "what ran is cancelled")
        self.assertEqual(self.motions.after(time.time(), WINDOW_S), ())
        self.assertEqual([text for text in self.errors if "Traceback" in text], [])
        self.assertLess(len(self.errors), 5, self.errors)
        wait_until(self.is_restored, "the lease of the supervisor has run out")
        wait_until(lambda: self.orders.state.phase == UseCaseState.IDLE, "it takes orders again")
        run = self.orders.start(2)
        state = self.orders.wait_for_end(run)
        self.assertEqual(state.ended.ending, Ending.COMPLETE, state.ended)
        found = self.orders.account(run)
        self.assertEqual((found.fixed_again, found.omitted), ((), ()))

    def test_the_file_is_deleted(self):
        self.lose(delete, "gone")

    def test_the_file_is_emptied(self):
        self.lose(empty, "production database")


if __name__ == "__main__":
    rostest.rosrun("remodel_planner", "test_database_loss", DatabaseLossTest)
