"""The committed behaviors are what the charts say, byte for byte."""

import os
import shutil
from pathlib import Path

import pytest

from flexbe_synthesizer.command_line import main
from flexbe_synthesizer.testing import app_complaints

PACKAGE = Path(__file__).parents[2]
CHARTS = sorted((PACKAGE / "charts").glob("*.xml"))
BEHAVIORS = sorted((PACKAGE / "src" / "remodel_behaviors").glob("*_sm.py"))


def test_regenerating_all_behaviors_changes_nothing(tmp_path):
    copy = tmp_path / "remodel_behaviors"
    shutil.copytree(PACKAGE / "src", copy / "src", ignore=shutil.ignore_patterns("*_sm.py"))
    shutil.copy(PACKAGE / "package.xml", copy)
    arguments = [*map(str, CHARTS), "--output", str(copy)]
    assert main(arguments, os.environ["ROS_PACKAGE_PATH"]) == 0
    for folder, pattern in (
        ("src/remodel_behaviors", "*_sm.py"),
        ("manifest", "*.xml"),
        ("certificate", "*.yaml"),
    ):
        committed = {path.name: path.read_bytes() for path in (PACKAGE / folder).glob(pattern)}
        generated = {path.name: path.read_bytes() for path in (copy / folder).glob(pattern)}
        assert generated == committed, "run `make behaviors` and commit what it changes"
        assert len(generated) == len(CHARTS)


@pytest.mark.parametrize("behavior", BEHAVIORS, ids=lambda path: path.stem)
def test_the_app_can_read_each_behavior(behavior):
    assert app_complaints(behavior.read_text(encoding="utf-8")) == []
