"""What the tests of a lost database share: a run during which it is damaged, and a backup."""

import shutil
import sys
import time
import unittest
from pathlib import Path

import rospy
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


class DatabaseLossCase(unittest.TestCase):
    """Damages the database of a run, and puts a backup back."""

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
