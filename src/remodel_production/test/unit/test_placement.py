"""Where devices are: by the catalogue, by a user's file, and by columns of a list."""

from dataclasses import replace
from pathlib import Path

import pytest
from wire_lists import CATALOGUE, MAPPINGS, read

from remodel_production.core.catalogue import Place
from remodel_production.core.imports.assembly import with_placement
from remodel_production.core.imports.formats import built_in_formats, format_of, import_design
from remodel_production.core.production import Mount
from remodel_production.errors import DesignError

EXAMPLES = Path("/usr/share/qelectrotech/examples")
LIST = b"Wire,From Device,From Pin,To Device,To Pin\n1,K1,A1,S1,13\n2,K1,A2,M1,U\n3,K1,1,X1,2\n"


def imported(data, catalogue=CATALOGUE):
    form = format_of(data, built_in_formats(MAPPINGS))
    return import_design(data, form, "test", "test", catalogue)


def mounts(found):
    return {component.name: component.mount for component in found.order.components}


def placed(text, data=LIST):
    return imported(data, with_placement(CATALOGUE, text))


@pytest.mark.parametrize(
    ("symbol", "place"),
    [
        ("references/ref_folio_suivant.elmt", Place.REFERENCE),
        ("10_electric/10_allpole/114_connections/lphd.elmt", Place.REFERENCE),
        ("grafcet/etape.elmt", Place.DRAWING),
        ("recepteurs/machines/moteur_tri.elmt", Place.OUTSIDE),
        ("01sources/multifilaire/src_3p_pen.elmt", Place.OUTSIDE),
        ("07securite_des_machines/securite/terre.elmt", Place.OUTSIDE),
        ("recepteurs/misc/pc.elmt", Place.OUTSIDE),
        ("recepteurs/domestiques/four.elmt", Place.OUTSIDE),
        ("contacts/poussoirs/a-u_004.elmt", Place.DOOR),
        ("10_electric/10_allpole/380_signaling&operating/20_push_buttons/au.elmt", Place.DOOR),
        ("elements/VOYANTS/Voyant Rouge.elmt", Place.DOOR),
        ("industrie/variateur_de_frequence/leroy_somer/digidrive_sk.elmt", Place.PLATE),
        ("02protections/disjoncteur_magneto_thermique/depart_moteur_tesys_2.elmt", Place.PLATE),
        ("140_connectors&plugs/20_socket_outlets/pc_mono_armoire.elmt", Place.PLATE),
        ("10_electric/10_allpole/130_terminals&terminal_strips/barette_de_terre.elmt", Place.PLATE),
        ("gce/gce_x-8r.elmt", None),
    ],
)
def test_symbols_of_old_and_foreign_collections_have_their_places(symbol, place):
    assert CATALOGUE.place(f"embed://import/{symbol}", "simple") is place


def test_folio_references_and_motors_of_an_old_project_are_not_on_the_plate():
    found = imported((EXAMPLES / "tremie_vibrante.qet").read_bytes())
    assert {"1/C15", "3/B3", "2/A1"}.isdisjoint(mounts(found))
    assert {mounts(found)[name] for name in ("M1", "M2")} == {Mount.OUTSIDE}
    assert mounts(found)["aru 1"] is Mount.DOOR


def test_symbols_placed_by_default_are_listed_with_their_devices():
    found = imported((EXAMPLES / "tableau_domestique.qet").read_bytes())
    lines = [line for line in found.account.assumptions if "is mounted" in line]
    assert lines[1] == (
        "nothing says where symbol import/perso/ventilador-axial.elmt is mounted: the plate taken "
        "for ventilador-axial"
    )
    assert len(lines) == 2
    text = "devices: {lavavajillas: outside}\nsymbols: {'*/Ventilador-*': outside}"
    found = placed(text, (EXAMPLES / "tableau_domestique.qet").read_bytes())
    assert not [line for line in found.account.assumptions if "is mounted" in line]
    assert mounts(found)["lavavajillas"] is mounts(found)["ventilador-axial"] is Mount.OUTSIDE


def test_a_placement_decides_where_devices_are_and_which_wires_leave_the_plate():
    found = placed("devices: {S1: door, 'M*': outside, K1: plate}")
    assert mounts(found) == {
        "K1": Mount.PLATE,
        "S1": Mount.DOOR,
        "M1": Mount.OUTSIDE,
        "X1": Mount.PLATE,
    }
    assert found.order.leaving() == {"1": "S1:13 is in the door", "2": "M1:U is outside"}
    assert [wire.name for wire in found.order.in_cabinet().wires] == ["3"]


def test_devices_of_a_list_that_are_placed_by_default_are_counted():
    text = b"Wire,From,To,From place\n1,K1:1,S1:1,plate\n2,K1:2,X1:1,\n"
    (line,) = (each for each in imported(text).account.assumptions if "nothing says" in each)
    assert line.startswith("nothing says where 2 devices are mounted: the plate taken, such as for")
    decided = imported(text, with_placement(CATALOGUE, "devices: {S1: door, X1: plate}"))
    assert not any("nothing says" in each for each in decided.account.assumptions)


def test_a_placement_of_a_device_that_is_not_there_is_reported():
    line = "the placement names S9, and no device is called so"
    found = placed("devices: {S9: door}")
    assert line in found.account.assumptions
    assert line in found.order.notes


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("devices: {S1: roof}", "line 1: devices: S1: 'roof' found; allowed: plate, door, outside"),
        ("devices:\n  S1: drawing", "line 2: devices: S1: 'drawing' found; allowed: plate, door,"),
        ("symbols: {x: 1}", "symbols: x: 1 found; allowed: plate, door, outside, reference, draw"),
        ("doors: [S1]", "line 1: the placement: key doors is not known; allowed: devices, symbols"),
    ],
)
def test_a_malformed_placement_is_refused(text, said):
    with pytest.raises(DesignError, match=said):
        with_placement(CATALOGUE, text)


def test_columns_of_a_list_say_where_its_devices_are():
    text = (
        "Wire,From Device,From Pin,From Place,To Device,To Pin,To Placement\n"
        "1,K1,A1,plate,S1,13,Door\n2,K1,A2,,M1,U,outside\n3,S1,14,,X1,1,\n"
    )
    expected = {"S1": Mount.DOOR, "M1": Mount.OUTSIDE, "K1": Mount.PLATE, "X1": Mount.PLATE}
    assert mounts(read(text)) == expected
    pins = "Wire,Device,Pin,Place\n1,K1,A1,plate\n1,S1,13,door\n2,K1,A2,\n2,M1,U,outside\n"
    assert mounts(read(pins)) == {n: m for n, m in expected.items() if n != "X1"}


@pytest.mark.parametrize(
    ("second", "said"),
    [
        ("S1,roof", "line 3: to_place: 'roof' found for S1; allowed: plate, door, outside; call"),
        ("S1,plate", "line 3: to_place: S1 is at plate, and at door in line 2: give it one place"),
    ],
)
def test_a_place_that_is_not_known_or_contradicts_another_is_refused(second, said):
    text = f"Wire,From,To,To place\n1,K1:1,S1,door\n2,K1:2,{second}\n"
    with pytest.raises(DesignError, match=said):
        read(text)


def test_a_placement_counts_more_than_the_list():
    data = b"Wire,From,To,To place\n1,K1:1,S1:1,door\n"
    catalogue = replace(CATALOGUE, mounts=(("S1", Mount.PLATE),))
    assert mounts(imported(data, catalogue))["S1"] is Mount.PLATE
