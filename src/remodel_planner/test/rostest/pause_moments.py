"""Pause a running order at random moments, and note what moves although the pause was answered."""

from __future__ import annotations

import threading
import time
from random import Random

from motion_watch import Motion, MotionWatch
from order_client import OrderClient
from remodel_msgs.msg import UseCaseState

# [s] between a resume and the next pause.
_RUN_S = (0.02, 1.2)


class PauseMoments:
    """Pauses and resumes runs.

    Attributes:
        paused: how often a pause was answered while something was left to do.
        moved: what moved after each of these answers, before the run was resumed.
        waits_s: [s] wall time in which each pause was answered.
    """

    def __init__(self, orders: OrderClient, motions: MotionWatch, random: Random) -> None:
        """Take the client, and the watch; `random` draws the moments."""
        self.paused = 0
        self.moved: list[Motion] = []
        self.waits_s: list[float] = []
        self._orders = orders
        self._motions = motions
        self._random = random

    def pause(self, run: int, window_s: float) -> bool:
        """Pause a run once, at a random moment; return whether it was still under way.

        Args:
            run: number of the run.
            window_s: [s] wall time for which it stays paused and is watched.
        """
        until = time.monotonic() + self._random.uniform(*_RUN_S)
        while self._is_under_way(run) and time.monotonic() < until:
            threading.Event().wait(0.005)
        asked_s = time.monotonic()
        granted, text = self._orders.command("pause")
        answered_s = time.time()
        if not granted:
            assert not self._is_under_way(run) or "ended" in text or "no run" in text, text
            return False
        self.waits_s.append(time.monotonic() - asked_s)
        self.moved += self._motions.under_way(answered_s)
        self.moved += self._motions.after(answered_s, window_s)
        self._orders.wait_for_phase(UseCaseState.PAUSED)
        self.paused += 1
        self._orders.require("resume")
        return True

    def _is_under_way(self, run: int) -> bool:
        state = self._orders.state
        return bool(state.run == run and state.phase != UseCaseState.ENDED)
