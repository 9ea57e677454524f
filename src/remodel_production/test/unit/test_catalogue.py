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


def test_the_first_pattern_that_matches_decides():
    catalogue = read_catalogue(FILE)
    folder = "embed://import/20_manufacturers_articles/x"
    assert catalogue.place(f"{folder}/breaker.elmt", "simple") is Place.PLATE
    assert catalogue.place("embed://import/99_assembly_plan/x.elmt", "master") is Place.DRAWING


def test_reports_and_thumbnails_are_no_devices_in_any_collection():
    catalogue = read_catalogue(FILE)
    assert catalogue.place("embed://import/other/x.elmt", "next_report") is Place.REFERENCE
    assert catalogue.place("embed://import/other/x.elmt", "thumbnail") is Place.DRAWING


def test_without_a_pattern_only_a_terminal_has_a_place():
    assert read_catalogue(FILE).place("embed://import/other/x.elmt", "simple") is None
    assert read_catalogue(FILE).place("embed://import/other/x.elmt", "terminal") is Place.PLATE


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
