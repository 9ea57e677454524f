"""The catalogue's form is checked, and its rules are applied in their order."""

from pathlib import Path

import pytest
import yaml

from remodel_production.core.catalogue import Place
from remodel_production.edge.design_files import read_catalogue
from remodel_production.errors import CatalogueError

FILE = Path(__file__).parents[2] / "config" / "catalogue.yaml"


def data(**changes):
    return {**yaml.safe_load(FILE.read_text()), **changes}


@pytest.mark.parametrize(
    ("symbol", "link", "place"),
    [
        ("20_manufacturers_articles/x/breaker", "simple", Place.PLATE),
        ("99_assembly_plan/x", "master", Place.DRAWING),
        ("other/x", "next_report", Place.REFERENCE),
        ("other/x", "thumbnail", Place.DRAWING),
        ("other/x", "simple", None),
        ("other/x", "terminal", Place.PLATE),
    ],
)
def test_the_first_pattern_that_matches_decides_and_reports_are_no_devices(symbol, link, place):
    assert read_catalogue(FILE).place(f"embed://import/{symbol}.elmt", link) is place


@pytest.mark.parametrize(
    ("malformed", "problem"),
    [
        ([], "the file: found []; allowed: a value of type object"),
        ({}, "the file: found nothing; missing: placement, colour_names, "),
        (
            data(placement=[{"patterns": ["*"], "place": "moon"}]),
            "placement[0].place: found 'moon'; allowed: plate, door, outside, reference, drawing",
        ),
        (
            data(clamps={**data()["clamps"], "sections": {1.5: {"pitch": 0.008}}}),
            "clamps.sections.1.5: found pitch; missing: chamfer, retention",
        ),
        (
            data(clamps={**data()["clamps"], "sections": {"thick": {}}}),
            "clamps.sections: found 'thick'; allowed: a value of type number",
        ),
        (data(devices=[]), "devices: no row with part '*' and kind '*' for role device"),
        (
            data(cabinet={**data()["cabinet"], "rail": {"width": 0}}),
            "cabinet.rail: found width; missing: height",
        ),
        (data(terminals=[]), "terminals: no rule with part '*' for role device"),
        (
            data(terminals=[{**data()["terminals"][-1], "force_limit": 0}]),
            "terminals[0].force_limit: found 0; allowed: more than 0",
        ),
        (data(default_section="wide"), "default_section: found 'wide'; allowed: a value of type"),
    ],
)
def test_a_malformed_catalogue_is_refused_by_place(malformed, problem, tmp_path):
    file = tmp_path / "catalogue.yaml"
    file.write_text(yaml.safe_dump(malformed))
    with pytest.raises(CatalogueError) as caught:
        read_catalogue(file)
    assert f"{file}: {problem}" in str(caught.value)


def test_a_file_that_is_no_yaml_is_refused(tmp_path):
    file = tmp_path / "catalogue.yaml"
    file.write_text("a: [")
    with pytest.raises(CatalogueError, match=r"catalogue\.yaml"):
        read_catalogue(file)


def test_a_users_wire_materials_that_cannot_be_read_are_refused(tmp_path, monkeypatch):
    monkeypatch.setenv("REMODEL_WIRE_MATERIALS", str(tmp_path / "own.yaml"))
    with pytest.raises(CatalogueError, match=r"own\.yaml"):
        read_catalogue(FILE)
