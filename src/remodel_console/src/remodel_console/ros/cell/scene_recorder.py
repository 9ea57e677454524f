"""Record the cell in three dimensions, and userdata, while an order runs, for Replay."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress
from typing import TextIO

import rospy

from remodel_console.core.cell.cell_state import CellState, change_between, frame_text
from remodel_console.core.run.state_values import StateValues
from remodel_console.core.use_case.use_case import UseCase
from remodel_console.edge.scene_files import SceneFiles
from remodel_console.watched import Scene

_POLL_S = 0.02  # wall time
_PERIOD_S = 0.1  # between two frames, ROS time


class SceneRecorder:
    """Writes what has changed in a scene and in userdata, ten times in a second of the cell."""

    def __init__(
        self,
        scene: Scene,
        files: SceneFiles,
        use_case: Callable[[], UseCase | None],
        values: deque[StateValues],
        end: threading.Event,
    ) -> None:
        """Record each run that `use_case` returns, until the event is set.

        `values` holds the userdata that states have found; what is recorded is taken out.
        """
        self._scene = scene
        self._files = files
        self._use_case = use_case
        self._values = values
        self._end = end
        self._run: tuple[int, str] | None = None
        self._file: TextIO | None = None
        self._state = CellState()
        self._written_s = 0.0
        self._is_first = True
        threading.Thread(target=self._record, name="scene recorder", daemon=True).start()

    def _record(self) -> None:
        while not self._end.wait(_POLL_S):
            self._follow_run()
            if self._file is not None:
                self._write()
            else:
                self._values.clear()
        self._close()

    def _follow_run(self) -> None:
        """Begin and end with the runs."""
        now = self._use_case()
        run = (now.run, now.order) if now is not None and now.is_under_way and now.run else None
        if run == self._run:
            return
        self._close()
        self._run = run
        if run is None:
            return
        try:
            self._file = self._files.begin(
                *run,
                begun_s=time.time(),
                started_s=now.started_s,
                goes_on=now.interruptions > 0,
            )
        except OSError as error:
            rospy.logwarn("run %d of %s is not recorded in three dimensions: %s", *run, error)
            return
        self._state, self._written_s, self._is_first = CellState(), 0.0, True
        self._scene.add_viewer(1)

    def _write(self) -> None:
        now_s = rospy.get_time()
        if 0.0 <= now_s - self._written_s < _PERIOD_S or self._file is None:
            return
        state = self._scene.now
        change = change_between(self._state, state)
        changes = [change] if change else []
        while self._values:
            changes.append({"values": self._values.popleft().as_json()})
        self._written_s = now_s
        if not changes:
            return
        if self._is_first:
            changes[0]["whole"] = True
        self._state, self._is_first = state, False
        try:
            self._file.writelines(frame_text(now_s, one) for one in changes)
            self._file.flush()
        except OSError as error:
            rospy.logwarn("the recording in three dimensions ends: %s", error)
            run = self._run
            self._close()
            self._run = run  # it is not begun again

    def _close(self) -> None:
        self._run = None
        if self._file is not None:
            self._scene.add_viewer(-1)
            with suppress(OSError):  # of a full disk: what is still to be written is lost
                self._file.close()
            self._file = None
