"""`remodel SUBCOMMAND` starts every command, is on the PATH, and is completed by bash."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from remodel_planner.commands import remodel

PACKAGE = Path(__file__).parents[2]
HOOK = PACKAGE / "env-hooks/50.remodel.bash"
SUBCOMMANDS = sorted(remodel.COMMANDS)


def test_every_subcommand_is_listed(capsys):
    assert remodel.main(["--help"]) == 0
    printed = capsys.readouterr().out
    listed = [line.split()[0] for line in printed.splitlines() if line.startswith("  ")]
    assert sorted(listed) == SUBCOMMANDS


@pytest.mark.parametrize("name", SUBCOMMANDS)
def test_a_subcommand_prints_its_help(name, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["remodel"])  # a subcommand changes it
    with pytest.raises(SystemExit) as ended:
        remodel.main([name, "--help"])
    assert ended.value.code == 0
    assert capsys.readouterr().out.startswith(f"usage: remodel {name}")


def test_without_a_subcommand_or_with_an_unknown_one_it_says_which_there_are(capsys):
    assert remodel.main([]) == 2
    assert "  run " in capsys.readouterr().err
    assert remodel.main(["fly"]) == 2
    assert "no subcommand fly; there are: import, " in capsys.readouterr().err


def test_a_sourced_workspace_has_the_command_and_an_error_has_its_exit_code(tmp_path):
    missing = f"{tmp_path}/missing.json"
    done = subprocess.run(
        ["remodel", "check", missing, missing], capture_output=True, text=True, timeout=60
    )
    assert (done.returncode, done.stderr.splitlines()[0].split()[0]) == (1, "check:")


@pytest.mark.parametrize(
    ("words", "expected"),
    [("remodel ex", {"expectations", "explain", "export"}), ("remodel", set())],
)
def test_bash_completes_subcommands_and_then_files(words, expected):
    line = words.split()
    script = (
        f"source {HOOK}; COMP_WORDS=({words}); COMP_CWORD={len(line) - 1}; COMPREPLY=(); _remodel; "
        "echo ${COMPREPLY[@]}"
    )
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, timeout=60)
    assert set(done.stdout.split()) == expected
    offered = re.search(r'-W "(.*?)"', HOOK.read_text(), re.DOTALL)[1].replace("\\", " ").split()
    assert offered == SUBCOMMANDS
