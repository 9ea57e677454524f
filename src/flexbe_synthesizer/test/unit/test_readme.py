"""The README tells the truth about codes, and its chart is one."""

import re
from pathlib import Path

from flexbe_synthesizer.core.codec import EXTENSION, parse_chart, write_chart
from flexbe_synthesizer.core.problem import Code, Severity
from flexbe_synthesizer.request import ErrorCode

README = (Path(__file__).parents[2] / "README.md").read_text()


def test_every_code_of_a_problem_stands_in_the_table():
    rows = re.findall(r"^\| `([\w-]+)` \| ([^|]+) \|$", README, re.MULTILINE)
    warning = {Severity.WARNING: " (warning)", Severity.ERROR: ""}
    codes = [(code.slug, code.meaning + warning[code.severity]) for code in Code]
    assert [row for row in rows if row[0] in {slug for slug, _ in codes}] == codes


def test_every_error_code_of_the_server_stands_in_the_table():
    rows = re.findall(r"^\| (\d+) (\w+) \|", README, re.MULTILINE)
    assert rows == [(str(code.value), code.name) for code in ErrorCode]


def test_the_chart_shown_is_a_chart():
    (text,) = re.findall(r"```xml\n(.*?)```", README, re.DOTALL)
    chart = parse_chart(text)
    assert parse_chart(write_chart(chart)) == chart
    assert EXTENSION in README
