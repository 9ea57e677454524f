"""The file with tokens, and the kept log; no ROS."""

import stat

import pytest

from remodel_console.core.run.log_line import LogLine
from remodel_console.edge.log_file import LogFile
from remodel_console.edge.token_file import read_tokens


def test_tokens_are_written_once_for_their_owner_alone(tmp_path):
    file = tmp_path / "new" / "tokens.json"
    operator, observer = read_tokens(file)
    assert len(operator) >= 32
    assert operator != observer
    assert stat.S_IMODE(file.stat().st_mode) == 0o600
    assert read_tokens(file) == (operator, observer)


@pytest.mark.parametrize(
    ("text", "mode", "reason"),
    [
        ('{"operator": "a"}', 0o644, "chmod 600"),
        ("token", 0o600, "no JSON"),
        ("[]", 0o600, "holds no tokens"),
        ('{"operator": ""}', 0o600, "holds no tokens"),
        ('{"operator": "a", "chief": "b"}', 0o600, "holds no tokens"),
        ('{"operator": 7}', 0o600, "holds no tokens"),
    ],
)
def test_what_is_no_file_of_tokens_is_refused(tmp_path, text, mode, reason):
    file = tmp_path / "tokens.json"
    file.write_text(text)
    file.chmod(mode)
    with pytest.raises(ValueError, match=reason):
        read_tokens(file)


def test_an_operator_alone_is_enough(tmp_path):
    file = tmp_path / "tokens.json"
    file.write_text('{"operator": "a"}')
    file.chmod(0o600)
    assert read_tokens(file) == ("a", "")


def test_the_log_survives_a_restart_and_stays_short(tmp_path):
    file = tmp_path / "log.jsonl"
    first = LogFile(file)
    lines = [LogLine(float(n), 0, f"line {n}\nwith more") for n in range(10_500)]
    for line in lines:
        first.write(line)
    with file.open("a") as cut_off:
        cut_off.write('[1.0, 0, "cut')
    assert LogFile(file).lines == tuple(lines[-499:])
    assert len(file.read_text().splitlines()) <= 500
