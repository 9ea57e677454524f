"""tools/build.sh and tools/setup.sh, in a copy of their folder, with a catkin_make that fails."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

TOOLS = Path(__file__).parents[1] / "tools"

# Fails at the call whose number is in FAIL_AT; the first call makes what the second one sources.
CATKIN_MAKE = """\
#!/bin/sh
echo call >>calls
[ "$(wc -l <calls)" -ne "$FAIL_AT" ] || { echo 'robot.cpp:3: error: expected ;'; exit 2; }
mkdir -p devel
echo ': "$A_VARIABLE_THAT_CATKIN_DOES_NOT_SET"' >devel/setup.sh
"""


@pytest.fixture
def workspace(tmp_path):
    return copy_of_tools(tmp_path / "workspace")


def copy_of_tools(folder):
    shutil.copytree(TOOLS, folder / "tools")
    (folder / "bin").mkdir()
    (folder / "bin" / "catkin_make").write_text(CATKIN_MAKE)
    (folder / "bin" / "catkin_make").chmod(0o755)
    return folder


def run(workspace, script, fail_at=0, **variables):
    path = f"{workspace / 'bin'}:{os.environ['PATH']}"
    return subprocess.run(
        [workspace / "tools" / script],
        env={**os.environ, "PATH": path, "FAIL_AT": str(fail_at), **variables},
        capture_output=True,
        text=True,
        timeout=30,
    )


@pytest.mark.parametrize("call", [1, 2])
def test_a_build_that_fails_fails(workspace, call):
    built = run(workspace, "build.sh", fail_at=call)
    assert built.returncode == 2
    assert "robot.cpp:3: error: expected ;" in built.stderr
    assert "the whole log is in build/build.log" in built.stderr
    assert len((workspace / "calls").read_text().split()) == call


def test_a_build_that_failed_is_configured_again(workspace):
    assert run(workspace, "build.sh", fail_at=2).returncode == 2
    assert run(workspace, "build.sh").returncode == 0
    assert len((workspace / "calls").read_text().split()) == 4


def test_a_build_succeeds_and_is_configured_once(workspace):
    assert run(workspace, "build.sh").returncode == 0
    assert run(workspace, "build.sh").returncode == 0
    assert len((workspace / "calls").read_text().split()) == 3


def test_a_machine_without_a_compiler_is_refused_in_a_sentence(workspace):
    refused = run(workspace, "build.sh", CXX="no-compiler -O2")
    assert refused.returncode == 1
    assert refused.stderr == (
        "build: no C++ compiler: no-compiler -O2 is not found; install it (apt-get install g++), "
        "or set CXX\n"
    )
    assert not (workspace / "calls").exists()


def test_a_path_with_a_blank_is_refused_before_anything_is_done(tmp_path):
    workspace = copy_of_tools(tmp_path / "my workspace")
    refused = run(workspace, "setup.sh")
    assert refused.returncode == 1
    assert len(refused.stderr.splitlines()) == 1
    assert f"'{workspace}'" in refused.stderr
    assert not refused.stdout
    assert sorted(path.name for path in workspace.iterdir()) == ["bin", "tools"]
