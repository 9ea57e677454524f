"""Have each operation's record kept before the next operation begins.

A supervisor that survives its own death needs every finished operation in its database before
anything else moves. It says so by the parameter `remodel/recorder`: the name of its service of type
remodel_msgs/KeepRecord. Without the parameter nobody is asked.

A thread of its own sends the records, one after the other over one connection, and tries again
until each is kept or given up; the state only looks.
"""

from __future__ import annotations

import queue
import threading
import time
from functools import cache

import rospy
from remodel_msgs.msg import AbilityRecord
from remodel_msgs.srv import KeepRecord, KeepRecordRequest

RECORDER_PARAMETER = "remodel/recorder"

# [s] Wall time, as the recorder is a process and not a part of the cell: longer than it takes to
# start anew, shorter than the patience of a person who waits.
KEEP_LIMIT_S = 30.0

# [s] Wall time between two tries.
_RETRY_S = 0.25


def recorder() -> str:
    """Ask the master for the recorder's service; empty if records need not be kept.

    It takes a millisecond: rospy's cache does not remember that a parameter is not set.
    """
    return str(rospy.get_param(RECORDER_PARAMETER, ""))


class Keeping:
    """A record that is to be kept.

    Attributes:
        record: what is to be kept.
        recorder: name of the service that is asked.
        trouble: why it is not kept so far; empty if nobody has answered.
        is_settled: whether it is kept, or need not be any more.
    """

    def __init__(self, record: AbilityRecord, recorder: str) -> None:
        """Begin to wait."""
        self.record = record
        self.recorder = recorder
        self.trouble = ""
        self.is_settled = False
        self._since = time.monotonic()
        self._given_up = threading.Event()

    @property
    def is_overdue(self) -> bool:
        """Return whether the recorder has had its time."""
        return time.monotonic() - self._since > KEEP_LIMIT_S

    def give_up(self) -> None:
        """Wait no longer: a record that is not kept is sent once more, whatever comes of it."""
        self._given_up.set()

    def wait_for_retry(self) -> bool:
        """Wait until it is to be sent again; return whether that is the last time."""
        return self._given_up.wait(_RETRY_S)


class RecordKeeper:
    """The thread that sends records."""

    def __init__(self) -> None:
        """Start the thread; it ends with the process."""
        self._proxy: rospy.ServiceProxy | None = None
        self._connected_to = ""
        self._queue: queue.SimpleQueue[Keeping] = queue.SimpleQueue()
        threading.Thread(target=self._work, name="record keeper", daemon=True).start()

    def keep(self, record: AbilityRecord, recorder: str) -> Keeping:
        """Begin to have a record kept; return at once."""
        keeping = Keeping(record, recorder)
        self._queue.put(keeping)
        return keeping

    def _work(self) -> None:
        while True:
            keeping = self._queue.get()
            is_last = False
            while not self._send(keeping) and not is_last:
                is_last = keeping.wait_for_retry()

    def _send(self, keeping: Keeping) -> bool:
        """Return whether a record is settled."""
        try:
            if keeping.trouble:  # the recorder may be another one by now, or none
                keeping.recorder = recorder()
            keeping.is_settled = not keeping.recorder or self._ask(keeping)
        except Exception as error:  # noqa: BLE001 - rospy promises no type; the thread goes on
            keeping.trouble = str(error) or type(error).__name__
            self._disconnect()
        return keeping.is_settled

    def _ask(self, keeping: Keeping) -> bool:
        if self._connected_to != keeping.recorder:
            self._disconnect()
        if self._proxy is None:
            self._proxy = rospy.ServiceProxy(keeping.recorder, KeepRecord, persistent=True)
            self._connected_to = keeping.recorder
        response = self._proxy.call(KeepRecordRequest(keeping.record))
        if not response.success:
            keeping.trouble = response.message or "it gave no reason"
        return response.success

    def _disconnect(self) -> None:
        if self._proxy is not None:
            self._proxy.close()
            self._proxy = None


@cache
def keeper() -> RecordKeeper:
    """Return the process's keeper: the states of all behaviors share its connection."""
    return RecordKeeper()
