"""Serve the records of runs to consoles: remodel/use_case/runs, record and statistics."""

from __future__ import annotations

from datetime import UTC
from pathlib import Path

import rospy
from remodel_msgs.msg import RunEntry, RunSummary
from remodel_msgs.srv import (
    GetRun,
    GetRunRequest,
    GetRunResponse,
    GetStatistics,
    GetStatisticsRequest,
    GetStatisticsResponse,
    ListRuns,
    ListRunsResponse,
)
from sensor_msgs.msg import CompressedImage

from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_production.errors import PlannerError
from remodel_run.record import Entry
from remodel_supervision.core.runs.event_table import entries_of, state_after
from remodel_supervision.core.runs.events import Ending
from remodel_supervision.core.runs.state import RunState
from remodel_supervision.core.runs.sums import RunStatistics, joined, statistics_of_run, sums_of
from remodel_supervision.edge.run_log import KeptEvent, RunHead, RunLog
from remodel_supervision.ros.server.state_publisher import sums_message

# How many entries one answer has at most, and how many with pictures.
_AT_ONCE = 2000
_PICTURES_AT_ONCE = 20


class RecordServer:
    """Answers what was done in runs."""

    def __init__(self, database: ProductionDatabase, runs: Path) -> None:
        """Begin to serve.

        Args:
            database: that has the orders, and keeps the runs.
            runs: folder of the runs' pictures.
        """
        self._database = database
        self._log = RunLog(database)
        self._runs = runs
        # Of runs that have ended: they never change.
        self._summaries: dict[int, RunSummary] = {}
        self._entries: dict[int, list[RunEntry]] = {}
        self._statistics: dict[int, RunStatistics] = {}
        rospy.Service("remodel/use_case/runs", ListRuns, self._on_list)
        rospy.Service("remodel/use_case/record", GetRun, self._on_get)
        rospy.Service("remodel/use_case/statistics", GetStatistics, self._on_statistics)

    def _on_list(self, _: object) -> ListRunsResponse:
        try:
            summaries = [self._summary(head) for head in self._log.heads()]
            return ListRunsResponse(True, "", summaries, list(self._database.order_names()))
        except PlannerError as error:
            return ListRunsResponse(success=False, message=str(error))

    def _on_get(self, request: GetRunRequest) -> GetRunResponse:
        try:
            entries = self._of(request.run)
            first = max(1, request.first)
            limit = _PICTURES_AT_ONCE if request.with_pictures else _AT_ONCE
            count = min(request.count or limit, limit)
            wanted = entries[first - 1 : first - 1 + count]
            if request.with_pictures:
                wanted = [self._with_picture(request.run, entry) for entry in wanted]
        except PlannerError as error:
            return GetRunResponse(success=False, message=str(error))
        return GetRunResponse(True, "", wanted, len(entries))

    def _on_statistics(self, request: GetStatisticsRequest) -> GetStatisticsResponse:
        try:
            heads = [head for head in self._log.heads() if request.order in ("", head.order)]
            found = joined(map(self._statistics_of, heads))
        except PlannerError as error:
            return GetStatisticsResponse(success=False, message=str(error))
        return GetStatisticsResponse(
            success=True,
            runs=[run for run, _ in found.yields],
            sums=[sums_message(sums) for _, sums in found.sums],
            yields=[share for _, share in found.yields],
            utilisations=[share for _, share in found.utilisations],
            terminals=[terminal for terminal, _, _ in found.terminals],
            insertions=[count for _, count, _ in found.terminals],
            failures=[count for _, _, count in found.terminals],
            wires=[wire for wire, _ in found.wires],
            wire_s=[time_s for _, time_s in found.wires],
        )

    def _statistics_of(self, head: RunHead) -> RunStatistics:
        if head.number in self._statistics:
            return self._statistics[head.number]
        events = [each.event for each in self._log.events(head.number, charts=False)]
        state = state_after(events)
        found = statistics_of_run(head.number, state, events)
        if state.ended is not None:
            self._statistics[head.number] = found
        return found

    def _summary(self, head: RunHead) -> RunSummary:
        if head.number in self._summaries:
            return self._summaries[head.number]
        summary = summary_message(head, self._log.state(head.number))
        if summary.ended:
            self._summaries[head.number] = summary
        return summary

    def _of(self, run: int) -> list[RunEntry]:
        if run in self._entries:
            return self._entries[run]
        kept: tuple[KeptEvent, ...] = tuple(self._log.events(run))
        events = [each.event for each in kept]
        entries = [entry_message(entry) for entry in entries_of(events)]
        if state_after(events).ended is not None:
            self._entries = {run: entries}
        return entries

    def _with_picture(self, run: int, entry: RunEntry) -> RunEntry:
        """Return an entry with its picture; without, if its file is gone."""
        file = self._runs / str(run) / Path(entry.because).name
        if not entry.has_picture or not file.is_file():
            return entry
        seen = {name: getattr(entry, name) for name in RunEntry.__slots__}
        return RunEntry(**seen | {"picture": CompressedImage(None, "jpeg", file.read_bytes())})


def summary_message(head: RunHead, state: RunState) -> RunSummary:
    """Return a run as a list of runs shows it."""
    return RunSummary(
        run=head.number,
        order=head.order,
        use_case=state.use_case,
        cell=head.cell,
        started=rospy.Time.from_sec(head.started.replace(tzinfo=UTC).timestamp()),
        ended=state.ended is not None,
        success=state.ended is not None and state.ended.ending is Ending.COMPLETE,
        message=state.ended.because if state.ended else "",
        sums=sums_message(sums_of(state)),
    )


def entry_message(entry: Entry) -> RunEntry:
    """Return an entry of a run's record, without its picture."""
    return RunEntry(
        position=entry.position,
        stamp=rospy.Time.from_sec(entry.time_s),
        kind=entry.kind.value,
        task=entry.task,
        behavior=entry.behavior,
        state_path=entry.state_path,
        ability=entry.ability,
        fault=entry.fault,
        error_code=entry.error_code,
        text=entry.text,
        because=entry.because,
        names=[name for name, _ in entry.values],
        values=[value for _, value in entry.values],
        has_picture=entry.has_picture,
    )
