"""The README is right about the server's codes."""

import re
from pathlib import Path

from flexbe_synthesizer.synthesis import ErrorCode

README = (Path(__file__).parents[2] / "README.md").read_text()


def test_every_error_code_of_the_server_stands_in_the_table():
    rows = re.findall(r"^\| (\d+) (\w+) \|", README, re.MULTILINE)
    assert rows == [(str(code.value), code.name) for code in ErrorCode]
