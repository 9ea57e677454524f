"""The README is right about the server's codes, and its charts are charts."""

import re
from pathlib import Path

from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from flexbe_synthesizer.core.chart.chart_writer import write_chart
from flexbe_synthesizer.core.chart.grammar import EXTENSION
from flexbe_synthesizer.synthesis import ErrorCode

README = (Path(__file__).parents[2] / "README.md").read_text()


def test_every_error_code_of_the_server_stands_in_the_table():
    rows = re.findall(r"^\| (\d+) (\w+) \|", README, re.MULTILINE)
    assert rows == [(str(code.value), code.name) for code in ErrorCode]


def test_the_charts_shown_are_charts():
    texts = re.findall(r"```xml\n(.*?)```", README, re.DOTALL)
    assert len(texts) == 2
    for text in texts:
        chart = parse_chart(text)
        assert parse_chart(write_chart(chart)) == chart
    assert EXTENSION in README
