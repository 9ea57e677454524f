"""The userdata that each state finds while an order runs, read from the engine."""

from __future__ import annotations

import threading

import rospy

from remodel_console.core.run.run_view import Phase
from remodel_console.core.run.state_values import StateValues, values_around
from remodel_console.errors import CommandError
from remodel_console.live import Live
from remodel_console.ros.engine_link import EngineLink

_POLL_S = 0.05  # wall time; a state that ends sooner may not be seen


class ValuesLink:
    """Reads the userdata whenever another state has become active.

    Attributes:
        now: what was read last; None before that.
    """

    def __init__(self, live: Live, engine: EngineLink, end: threading.Event) -> None:
        """Follow the runs of orders until the event is set."""
        self._live = live
        self._engine = engine
        self._end = end
        self._known: object = None
        self.now: StateValues | None = None
        threading.Thread(target=self._follow, name="values", daemon=True).start()

    def _follow(self) -> None:
        while not self._end.wait(_POLL_S):
            active = self._active()
            if active is None:
                self._known = None
            if active is None or active == self._known:
                continue
            path, time_s = active[-1], rospy.get_time()
            try:
                found = self._engine.userdata()
            except CommandError:
                continue  # the behavior has ended meanwhile, or the engine is busy
            if self._active() == active:  # else the next state may have found others
                self._known = active
                self.now = StateValues(time_s, path, values_around(path, found))

    def _active(self) -> tuple[int, str] | None:
        """Return what runs, and which state is active, while an order is under way."""
        world = self._live.world
        use_case, run = world.use_case, world.run
        if use_case is None or not use_case.is_under_way or run.phase is not Phase.RUNNING:
            return None
        return (run.behavior_id, run.active) if run.active else None
