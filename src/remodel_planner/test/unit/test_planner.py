"""`planner SUBCOMMAND` starts every command; the names of the release before still do."""

import subprocess
import sys
from pathlib import Path

import pytest

from remodel_planner.commands import planner

NODES = Path(__file__).parents[2] / "nodes"
SUBCOMMANDS = sorted(path.name for path in NODES.iterdir() if path.name != "planner")


def run(*line):
    return subprocess.run([sys.executable, *line], capture_output=True, text=True, timeout=60)


def test_every_old_name_is_a_subcommand_and_every_subcommand_is_listed(capsys):
    assert planner.main(["--help"]) == 0
    printed = capsys.readouterr().out
    subcommands = [line.split()[0] for line in printed.splitlines() if line.startswith("  ")]
    assert sorted(subcommands) == SUBCOMMANDS


@pytest.mark.parametrize("name", SUBCOMMANDS)
def test_a_subcommand_prints_its_help(name, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["planner"])  # a subcommand changes it
    with pytest.raises(SystemExit) as ended:
        planner.main([name, "--help"])
    assert ended.value.code == 0
    assert capsys.readouterr().out.startswith(f"usage: planner {name}")


def test_without_a_subcommand_or_with_an_unknown_one_it_says_which_there_are(capsys):
    assert planner.main([]) == 2
    assert "run_order" in capsys.readouterr().err
    assert planner.main(["fly"]) == 2
    assert "no subcommand fly; there are: import, " in capsys.readouterr().err


def test_an_old_name_does_the_same_and_prints_the_new_one(tmp_path):
    missing = f"{tmp_path}/missing.json"
    old = run(NODES / "check", missing, missing)
    new = run(NODES / "planner", "check", missing, missing)
    assert old.returncode == new.returncode == 1
    first, *rest = old.stderr.splitlines()
    assert "`rosrun remodel_planner planner check`" in first
    assert rest == new.stderr.splitlines() != []
