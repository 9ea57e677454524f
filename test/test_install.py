"""An installed workspace runs when its sources, its build and its environment are gone."""

import os
import shutil
import socket
import subprocess
import sys
from pathlib import Path

import pytest
from catkin_pkg.packages import find_packages

ROOT = Path(__file__).parents[1]
INSTALLER = ROOT / "src/remodel_environment/install_environment.py"
# [s] Wall time of one command; the machine may be busy.
LIMIT_S = 1800.0
# What a shell of a user has who has set up nothing.
BARE = {"HOME": os.environ.get("HOME", "/"), "PATH": "/usr/bin:/bin", "LANG": "C.UTF-8"}

DESIGN = "/usr/share/qelectrotech/examples/tableau_domestique.qet"
ORDER = """
. {prefix}/setup.bash
export ROS_PACKAGE_PATH={out}/remodel_order_behaviors:$ROS_PACKAGE_PATH
remodel import {design} --order one
roslaunch -p {port} remodel_planner order.launch \\
  output:={out} database:=$REMODEL_DATABASE >{out}/nodes.log 2>&1 &
trap "kill -INT $!; wait $!" EXIT
remodel run one --wait 300 --wires 1 --output {out}
"""


def run(folder, script, environment):
    """Run lines of shell; return what they print."""
    done = subprocess.run(
        ["bash", "-e", "-c", script],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def copy_of_sources(folder):
    """Copy what belongs to the workspace; its environment is only linked."""
    built = shutil.ignore_patterns(
        ".git", ".venv", "build", "devel", "install", "out", ".*_cache", "__pycache__"
    )
    shutil.copytree(ROOT, folder, ignore=built, symlinks=True)
    (folder / ".venv").symlink_to(Path(sys.prefix))
    return folder


@pytest.mark.slow
def test_an_installed_workspace_places_a_wire_without_its_sources(tmp_path):
    sources = copy_of_sources(tmp_path / "workspace")
    # Messages for Python alone: the others take most of the time of a build.
    other_languages = {"ROS_LANG_DISABLE": "gencpp:geneus:genlisp:gennodejs"}
    path = {"PATH": f"{sources}/.venv/bin:{BARE['PATH']}"}
    run(sources, f"tools/install.sh {tmp_path}/install", {**BARE, **path, **other_languages})
    sources.rename(tmp_path / "away")
    shutil.rmtree(tmp_path / "away")
    (tmp_path / "install").rename(prefix := tmp_path / "moved")

    (out := tmp_path / "out").mkdir()
    (out / "charts").mkdir()
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    names = {
        "ROS_MASTER_URI": f"http://127.0.0.1:{port}",
        "ROS_IP": "127.0.0.1",
        "ROS_LOG_DIR": str(out / "log"),
        "REMODEL_DATABASE": f"sqlite:///{out}/production.sqlite",
    }
    script = ORDER.format(prefix=prefix, out=out, port=port, design=DESIGN)
    printed = run(tmp_path, script, {**BARE, **names})
    assert "1 of 1 wire placed" in printed


def test_the_environment_is_installed_after_all_other_packages():
    packages = {package.name: package for package in find_packages(str(ROOT / "src")).values()}
    last = packages.pop("remodel_environment")
    assert sorted(packages) == sorted(depend.name for depend in last.build_depends)


@pytest.mark.parametrize(
    ("requirement", "problem"),
    [
        ("packaging==0.1", "needed: packaging==0.1"),
        ("no-such-package==1.0", "has no package 'no-such-package'"),
    ],
)
def test_a_python_without_what_is_needed_is_refused_before_anything_is_made(
    tmp_path, requirement, problem
):
    file = tmp_path / "requirements.txt"
    file.write_text(f"# What runs.\n{requirement}\n")
    refused = subprocess.run(
        [sys.executable, INSTALLER, file, tmp_path / "prefix"],
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
    )
    assert refused.returncode == 1
    assert problem in refused.stderr
    assert "Run `make build`" in refused.stderr
    assert not (tmp_path / "prefix").exists()
