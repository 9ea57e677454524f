"""Recorded runs as the console sees them, requested from the supervisor, which has the database."""

from __future__ import annotations

from collections.abc import Iterator

from remodel_msgs import msg, srv

from remodel_console.core.use_case.record import Record, Summary
from remodel_console.errors import CommandError
from remodel_console.ros import topics
from remodel_console.ros.call_service import call_service
from remodel_console.ros.run_values import sums_of
from remodel_run.record import Entry, Kind, Statistics

_KINDS = {kind.value: kind for kind in Kind}


class RecordLink:
    """Asks for runs and their records."""

    def runs(self) -> tuple[Summary, ...]:
        """Return the recorded runs, the latest first; see `call_service` for errors."""
        return tuple(map(summary_of, self._list().runs))

    def orders(self) -> tuple[str, ...]:
        """Return the names of all orders; see `call_service` for errors."""
        return tuple(self._list().orders)

    def statistics(self, order: str) -> Statistics:
        """Return the statistics of an order's runs; of an empty name: of all runs.

        Raises:
            CommandError: if no node serves them.
        """
        name = f"{topics.RUN_COMMANDS}/statistics"
        answer = call_service(name, srv.GetStatistics, srv.GetStatisticsRequest(order))
        if not answer.success:
            raise CommandError(f"the statistics cannot be read: {answer.message}")
        terminals = zip(answer.terminals, answer.insertions, answer.failures, strict=True)
        return Statistics(
            tuple(zip(answer.runs, map(sums_of, answer.sums), strict=True)),
            tuple(zip(answer.runs, answer.yields, strict=True)),
            tuple(zip(answer.runs, answer.utilisations, strict=True)),
            tuple(terminals),
            tuple(zip(answer.wires, answer.wire_s, strict=True)),
        )

    def record(self, run: int) -> Record:
        """Return the record of a run, without its pictures.

        Raises:
            CommandError: if no node serves it.
        """
        return Record(tuple(self._entries(run)))

    def picture(self, run: int, position: int) -> bytes:
        """Return the picture of an entry, as jpeg or png.

        Raises:
            CommandError: if there is none.
        """
        answer = _get(srv.GetRunRequest(run, position, 1, True))
        if not answer.entries or not answer.entries[0].has_picture:
            raise CommandError(f"entry {position} of run {run} has no picture")
        return bytes(answer.entries[0].picture.data)

    def _entries(self, run: int) -> Iterator[Entry]:
        """Yield all entries; the server gives some at once."""
        first = 1
        while True:
            answer = _get(srv.GetRunRequest(run, first, 0, False))
            yield from map(_entry, answer.entries)
            if not answer.entries or answer.entries[-1].position >= answer.total:
                return
            first = answer.entries[-1].position + 1

    @staticmethod
    def _list() -> srv.ListRunsResponse:
        answer = call_service(f"{topics.RUN_COMMANDS}/runs", srv.ListRuns, srv.ListRunsRequest())
        if not answer.success:
            raise CommandError(f"the runs cannot be listed: {answer.message}")
        return answer


def _get(request: srv.GetRunRequest) -> srv.GetRunResponse:
    answer = call_service(f"{topics.RUN_COMMANDS}/record", srv.GetRun, request)
    if not answer.success:
        raise CommandError(f"run {request.run} cannot be read: {answer.message}")
    return answer


def summary_of(message: msg.RunSummary) -> Summary:
    """Return a run as a list of runs shows it."""
    return Summary(
        run=message.run,
        order=message.order,
        use_case=message.use_case,
        cell=message.cell,
        started_s=message.started.to_sec(),
        has_ended=message.ended,
        is_success=message.success,
        message=message.message,
        sums=sums_of(message.sums),
    )


def _entry(message: msg.RunEntry) -> Entry:
    if message.kind not in _KINDS:
        text = (
            f"entry {message.position} is of the kind '{message.kind}', which is not known here; "
        )
        raise CommandError(f"{text}known are {', '.join(_KINDS)}")
    return Entry(
        position=message.position,
        time_s=message.stamp.to_sec(),
        kind=_KINDS[message.kind],
        task=message.task,
        behavior=message.behavior,
        state_path=message.state_path,
        ability=message.ability,
        fault=message.fault,
        error_code=message.error_code,
        text=message.text,
        because=message.because,
        values=tuple(zip(message.names, message.values, strict=False)),
        has_picture=message.has_picture,
    )
