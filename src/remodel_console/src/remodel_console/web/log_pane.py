"""The log on a page; its lines live in the browser, so that a long run costs the node nothing."""

from __future__ import annotations

import time
from collections.abc import Iterable

from nicegui.element import Element

from remodel_console.core.run.log_line import LogLine


class LogPane(Element, component="static/log_pane.js"):
    """Shows lines, the newest at the bottom."""

    def add(self, lines: Iterable[LogLine]) -> None:
        """Add lines."""
        self.run_method("add", [[_clock(line.time_s), line.severity, line.text] for line in lines])


def _clock(time_s: float) -> str:
    return time.strftime("%H:%M:%S", time.localtime(time_s))
