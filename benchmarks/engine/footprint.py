"""What the engine's process takes: memory, processor time and wake-ups, from outside, by /proc."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from pathlib import Path

_PAGE_BYTES = os.sysconf("SC_PAGE_SIZE")
_TICKS_PER_S = os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True)
class Load:
    """What a process did in a while.

    Attributes:
        cpu_percent: of one core.
        wakeups_hz: how often one of its threads began to run.
    """

    cpu_percent: float
    wakeups_hz: float


def resident_mb(pid: int) -> float:
    """Return the resident memory [MB]."""
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * _PAGE_BYTES / 1e6


def load(pid: int, seconds: float) -> Load:
    """Watch a process for a while."""
    cpu_s, wakeups = _cpu_s(pid), _wakeups(pid)
    time.sleep(seconds)
    return Load((_cpu_s(pid) - cpu_s) / seconds * 100, max(0, _wakeups(pid) - wakeups) / seconds)


def _cpu_s(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / _TICKS_PER_S


def _wakeups(pid: int) -> int:
    count = 0
    for status in Path(f"/proc/{pid}/task").glob("*/status"):
        for line in status.read_text().splitlines():
            if line.startswith("voluntary_ctxt_switches"):
                count += int(line.split()[1])
    return count
