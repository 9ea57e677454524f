"""The summary of a run for the terminal: what the end of its report says, in a few lines."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from remodel_planner.core.reports.net_list import Verdict
from remodel_planner.core.reports.run_report import Report
from remodel_run.progress import sums_words
from remodel_run.whole_task import counted

# Differences from the design that are listed; the report has all of them.
_LISTED = 8


def summary_lines(report: Report) -> Iterator[str]:
    """Yield the lines."""
    before = f" ({len(report.before)} of them before)" if report.before else ""
    if report.has_cables or report.done < report.sums.tasks:
        yield sums_words(report.sums)
    yield (
        f"{report.placed} of {counted(report.planned, 'wire')} placed{before}, "
        f"{report.first_pass} without a failed operation; "
        f"{counted(report.failures, 'failed operation')}; "
        f"{report.cell_s:.0f} s in the cell, {report.wall_s:.0f} s on the clock"
    )
    seated, ends = report.insertions
    if ends:
        yield (
            f"{seated} of {counted(ends, 'end')} seated by the first insertion; "
            f"{counted(report.recovered, 'wire')} recovered"
        )
    if report.real_time_factor is not None:
        yield (
            f"{report.simulated_s:.0f} s simulated in {report.wall_s:.0f} s, "
            f"real-time factor {report.real_time_factor:.2f}"
        )
    yield from _built_lines(report)
    if report.sums.by_hand:
        yield f"by hand: {counted(report.sums.by_hand, 'wire')}, listed in the report"


def _built_lines(report: Report) -> Iterator[str]:
    if report.unread:
        yield f"net list: not read back: {report.unread}"
        return
    if not report.nets:
        return
    counts = Counter(net.verdict for net in report.nets)
    others = "".join(
        f", {counts[verdict]} {verdict.value}"
        for verdict in (Verdict.WRONG, Verdict.MISSING)
        if counts[verdict]
    )
    right = counts[Verdict.AS_DESIGNED]
    yield f"net list: {right} of {counted(len(report.nets), 'wire')} as designed{others}"
    differences = report.differences
    for net in differences[:_LISTED]:
        designed = " to ".join(map(str, net.designed))
        yield f"  {net.wire} {net.verdict.value}: designed {designed}, {net.difference}"
    if len(differences) > _LISTED:
        yield f"  and {len(differences) - _LISTED} more"
    if report.in_ducts is not None:
        yield f"routes: below the rims at {report.in_ducts:.1%} of their length in ducts"
