"""What brings the Python environment into an install space."""

import subprocess
import sys
from pathlib import Path

import pytest
from catkin_pkg.packages import find_packages

ROOT = Path(__file__).parents[1]
INSTALLER = ROOT / "src/remodel_environment/install_environment.py"
# [s] Wall time of one command; the machine may be busy.
LIMIT_S = 120.0


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
