"""The committed behaviors are what the charts say, byte for byte."""

import os
import shutil
from pathlib import Path

import pytest
from app_judge import judge, judge_manifest

from flexbe_synthesizer.command_line import main
from flexbe_testing.edge.doctor import read_packages

PACKAGE = Path(__file__).parents[2]
CHARTS = sorted((PACKAGE / "charts").glob("*.xml"))
BEHAVIORS = sorted((PACKAGE / "src" / "remodel_behaviors").glob("*_sm.py"))


def test_regenerating_all_behaviors_changes_nothing(tmp_path):
    copy = tmp_path / "remodel_behaviors"
    shutil.copytree(PACKAGE / "src", copy / "src", ignore=shutil.ignore_patterns("*_sm.py"))
    shutil.copytree(PACKAGE / "charts", copy / "charts")
    shutil.copy(PACKAGE / "package.xml", copy)
    charts = [str(copy / "charts" / chart.name) for chart in CHARTS]
    assert main(charts, os.environ["ROS_PACKAGE_PATH"]) == 0
    for folder, pattern in (
        ("src/remodel_behaviors", "*_sm.py"),
        ("manifest", "*.xml"),
        ("certificate", "*.yaml"),
    ):
        committed = {path.name: path.read_bytes() for path in (PACKAGE / folder).glob(pattern)}
        generated = {path.name: path.read_bytes() for path in (copy / folder).glob(pattern)}
        assert generated == committed, "run `make behaviors` and commit what it changes"
        assert len(generated) == len(CHARTS)


@pytest.fixture(scope="module")
def known_to_app():
    sources = PACKAGE.parent
    flexbe_states = sources / "flexbe" / "flexbe_states"
    return read_packages([sources / "remodel_states", flexbe_states, PACKAGE])


@pytest.mark.parametrize("behavior", BEHAVIORS, ids=lambda path: path.stem)
def test_the_flexbe_app_saves_each_behavior_unchanged(behavior, known_to_app):
    text = behavior.read_text(encoding="utf-8")
    if behavior.stem == "test_behavior_example_sm":
        # Outcomes of Deliverable 5.1; the App drops their blanks (README of flexbe_synthesizer).
        named = ("PlacePin finished normally", "PlacePin takes longer than normal")
        for complaint, outcome in zip(judge(text, known_to_app), named, strict=False):
            assert f"'{outcome}' of '/PlacePin': the App drops the blanks" in complaint
        for outcome in named:
            text = text.replace(outcome, outcome.replace(" ", ""))
    assert judge(text, known_to_app) == []


@pytest.mark.parametrize("behavior", BEHAVIORS, ids=lambda path: path.stem)
def test_the_flexbe_app_reads_each_manifest(behavior, known_to_app):
    manifest = PACKAGE / "manifest" / f"{behavior.stem.removesuffix('_sm')}.xml"
    text = behavior.read_text(encoding="utf-8")
    assert judge_manifest(manifest.read_text(encoding="utf-8"), text, known_to_app) == []
