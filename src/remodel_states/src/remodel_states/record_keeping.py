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
    """Return the name of the recorder's service; empty if records need not be kept.

    The master tells this node of changes; only the first call asks it.
    """
    name = rospy.get_param_cached(RECORDER_PARAMETER, "")
    return name if isinstance(name, str) else ""


class Keeping:
    """A record that is to be kept.

    Attributes:
        trouble: why it is not kept so far; empty if nobody has answered.
    """

    def __init__(self, service: str, record: AbilityRecord) -> None:
        """Begin to wait."""
        self.service = service
        self.record = record
        self.trouble = ""
        self._since = time.monotonic()
        self._is_kept = False
        self._given_up = threading.Event()

    @property
    def is_settled(self) -> bool:
        """Return whether the record is kept, or need not be any more."""
        return self._is_kept or not recorder()

    @property
    def is_overdue(self) -> bool:
        """Return whether the recorder has had its time."""
        return time.monotonic() - self._since > KEEP_LIMIT_S

    def give_up(self) -> None:
        """Wait no longer: a record that is not kept is sent once more, whatever comes of it."""
        self._given_up.set()

    def send(self, connection: Connection) -> None:
        """Send the record until it is kept or given up; for the keeper's thread."""
        while not self._try(connection) and not self._given_up.is_set():
            self._given_up.wait(_RETRY_S)

    def _try(self, connection: Connection) -> bool:
        self.trouble = connection.call(self.record)
        self._is_kept = not self.trouble
        return self._is_kept


class Connection:
    """A line to the recorder, made anew when it breaks."""

    def __init__(self, service: str) -> None:
        """Connect at the first call."""
        self._service = service
        self._proxy: rospy.ServiceProxy | None = None

    def call(self, record: AbilityRecord) -> str:
        """Have a record kept; return why it is not, or nothing."""
        if self._proxy is None:
            self._proxy = rospy.ServiceProxy(self._service, KeepRecord, persistent=True)
        try:
            response = self._proxy.call(KeepRecordRequest(record))
        except Exception as error:  # noqa: BLE001 - rospy promises no type; the thread goes on
            self._proxy.close()
            self._proxy = None
            return str(error)
        return "" if response.success else response.message or "it gave no reason"


class RecordKeeper:
    """The thread that sends records to one recorder."""

    def __init__(self, service: str) -> None:
        """Start the thread; it ends with the process."""
        self._service = service
        self._queue: queue.SimpleQueue[Keeping] = queue.SimpleQueue()
        threading.Thread(target=self._work, name=f"keeper of {service}", daemon=True).start()

    def keep(self, record: AbilityRecord) -> Keeping:
        """Begin to have a record kept; return at once."""
        keeping = Keeping(self._service, record)
        self._queue.put(keeping)
        return keeping

    def _work(self) -> None:
        connection = Connection(self._service)
        while True:
            self._queue.get().send(connection)


@cache
def keeper_of(service: str) -> RecordKeeper:
    """Return the process's keeper for a recorder: states of one behavior share a connection."""
    return RecordKeeper(service)
