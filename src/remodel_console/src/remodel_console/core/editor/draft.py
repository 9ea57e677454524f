"""The chart that is edited, and the text that it stands in: the text is what is saved."""

from __future__ import annotations

from dataclasses import dataclass

from flexbe_synthesizer.core.chart.chart_reader import read_chart
from flexbe_synthesizer.core.chart.chart_writer import write_chart
from flexbe_synthesizer.core.chart.model import Chart
from flexbe_synthesizer.core.chart.problem import ChartError, errors_in
from flexbe_synthesizer.core.chart.xml_reader import decoded, encoded
from flexbe_synthesizer.core.rewrite.chart_rewriter import RewriteError, rewrite_chart
from remodel_console.errors import CommandError


@dataclass(frozen=True)
class Draft:
    """A version of the chart that is edited.

    Attributes:
        chart: what the text says.
        text: the XML, comments and layout included.
        origin: the file as it was when it was read or written; None: there was none.
    """

    chart: Chart
    text: str
    origin: bytes | None = None

    @property
    def content(self) -> bytes:
        """Return the text as its file holds it, in the encoding of the file that was read.

        Raises:
            CommandError: if the text declares an encoding that is not known.
        """
        if self.origin is not None and decoded(self.origin, self.chart.file) == self.text:
            return self.origin
        try:
            return encoded(self.text, self.chart.file, self.origin or b"")
        except ChartError as error:
            raise CommandError(str(error)) from error

    def changed(self, chart: Chart) -> Draft:
        """Return the draft of another chart: the text with no more changed than that takes.

        Raises:
            CommandError: if the text cannot be changed so.
        """
        try:
            return Draft(chart, rewrite_chart(self.text, chart), self.origin)
        except RewriteError as error:
            raise CommandError(f"the chart cannot be changed: {error}") from error

    def retyped(self, typed: str) -> Draft:
        """Return the draft of a text that was typed.

        Raises:
            CommandError: if it does not have the form of a chart.
        """
        text = with_line_ends(typed, self.text)
        chart, problems = read_chart(text, self.chart.file)
        if chart is None or errors_in(problems):
            raise CommandError("\n".join(map(str, problems)))
        return Draft(chart, text, self.origin)


def new_draft(chart: Chart) -> Draft:
    """Return the draft of a chart that has no file yet.

    Raises:
        CommandError: if it cannot be written as XML.
    """
    try:
        return Draft(chart, write_chart(chart))
    except ValueError as error:
        raise CommandError(f"the chart cannot be written: {error}") from error


def read_draft(content: bytes, file: str) -> Draft:
    """Return the draft of a chart's file.

    Raises:
        CommandError: if it does not hold what can be read as a chart.
    """
    chart, problems = read_chart(content, file)
    if chart is None:
        raise CommandError("\n".join(map(str, problems)))
    return Draft(chart, decoded(content, file), content)


def with_line_ends(typed: str, before: str) -> str:
    """Return a text that was typed, with the line ends that the text before it has.

    A page knows one kind only. Lines that did not change keep theirs, others get the first one's.
    """
    old = before.splitlines(keepends=True)
    new = typed.splitlines(keepends=True)
    end = "\r\n" if old and old[0].endswith("\r\n") else "\n"
    head = _same(old, new)
    rest = min(len(old), len(new)) - head
    tail = min(_same(old[::-1], new[::-1]), rest)
    middle = [line.rstrip("\r\n") + end * line.endswith("\n") for line in new[head:]]
    middle = middle[: len(middle) - tail]
    return "".join((*old[:head], *middle, *old[len(old) - tail :]))


def _same(old: list[str], new: list[str]) -> int:
    """Return how many lines are the same at the beginning, but for their ends."""
    count = 0
    for one, other in zip(old, new, strict=False):
        if one.rstrip("\r\n") != other.rstrip("\r\n") or one[-1:] != other[-1:]:
            return count
        count += 1
    return count
