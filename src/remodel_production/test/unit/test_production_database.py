"""Orders stored in the database are read back equal."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest
from databases import execute

from remodel_production.core.production import (
    Ability,
    AbilityParameter,
    Cable,
    Clip,
    Component,
    Mount,
    Node,
    Order,
    Pose,
    Role,
    Segment,
    SegmentKind,
    Side,
    Terminal,
    TerminalRef,
    Wire,
)
from remodel_production.edge.database.production_database import NEWEST, ProductionDatabase
from remodel_production.errors import OrderError

TURNED = Pose((1.0, 2.0, 3.0), (0.0, 0.0, 1.0, 0.0))
HARNESS = Order(
    "loom",
    "A loom",
    "loom.kbl",
    (
        Component(
            "X1",
            "plug",
            (
                Terminal(
                    "1",
                    Side.TOP,
                    "",
                    "contact 4711",
                    pose=TURNED,
                    approach=(0.0, 0.0, -1.0),
                    clearance_m=0.02,
                    insertion_force_limit_n=60.0,
                ),
            ),
            Mount.OUTSIDE,
            role=Role.CONNECTOR,
            part_number="P-1",
            pose=TURNED,
            node="N1",
        ),
        Component("X2", "plug", (Terminal("1", Side.BOTTOM),), node="N3"),
    ),
    wires=(
        Wire(
            "C1.1",
            TerminalRef("X1", "1"),
            TerminalRef("X2", "1"),
            "GNYE",
            section_mm2=0.35,
            source="line 3",
            number="2",
            length_m=0.7,
            cable="C1",
            core="1",
            route=("S1", "S2"),
        ),
    ),
    notes=("an assumption",),
    cables=(Cable("C1", "LiYCY", 0.8, True, source="line 4"),),
    nodes=(Node("N1", (0.0, 0.1, 0.2)), Node("N2", None), Node("N3", None)),
    segments=(
        Segment("S1", "N1", "N2", 0.3),
        Segment("S2", "N3", "N2", 0.4, kind=SegmentKind.DUCT),
    ),
    clips=(
        Clip("K1", "clip", "S2", 0.25),
        Clip("K2", "clip", "S2", 0.75),
        Clip("K3", "", node="N2"),
    ),
)
ORDER = replace(HARNESS, name="house")


def test_a_harness_comes_back_equal_with_its_routes(database):
    database.add_order(HARNESS)
    loom = database.order("loom")
    assert loom == HARNESS
    assert [clip.name for clip in loom.clips_of(loom.wires[0])] == ["K3", "K2", "K1"]


def test_preferences_come_back_as_they_were(database):
    wish = {"name": "blue first", "pick": {"colour": "BU"}, "before": {"colour": "BK"}, "weight": 2}
    document = {
        "format": "remodel-preferences-1",
        "weights": {"heavy": 12, "zone": 0},
        "prefer": [wish],
        "require": [{"name": "away", "arm": "R", "x_mm": [0, 100]}],
    }
    database.add_order(ORDER, document)
    database.add_order(HARNESS)
    assert database.preferences("house") == document
    assert database.preferences("loom") is None


def test_preferences_that_are_no_document_are_refused_with_the_order(database):
    with pytest.raises(OrderError, match="sections are needed"):
        database.add_order(ORDER, ["prefer"])
    with pytest.raises(OrderError, match="no order house"):
        database.order("house")


def test_abilities_are_kept_up_to_date(database):
    place = Ability("Place", "place it", (AbilityParameter("id", "string", "whose"),))
    parameters = (AbilityParameter("id", "string", "what"), AbilityParameter("f", "float64", ""))
    pick = Ability("Pick", "pick it", parameters)
    database.add_order(ORDER, abilities=(place,))
    database.add_order(HARNESS, abilities=(pick, Ability("Place", "lay it", ())))
    assert database.abilities() == (pick, Ability("Place", "lay it", ()))


def test_an_order_survives_its_process(database, url):
    database.add_order(ORDER)
    database.close()
    again = ProductionDatabase(url)
    assert again.order("house") == ORDER
    again.close()


def test_a_second_order_of_the_same_name_is_refused_whole(database, url):
    database.add_order(ORDER)
    with pytest.raises(OrderError, match="an order house already"):
        database.add_order(ORDER)
    assert execute(url, "SELECT count(*) FROM wires") == [(1,)]


def test_an_unknown_order_is_refused_with_those_there_are(database):
    database.add_order(ORDER)
    with pytest.raises(OrderError, match="no order hosue; it has: house"):
        database.order("hosue")


def test_no_database_at_the_url_is_an_order_error():
    with pytest.raises(OrderError, match="unable to open database file"):
        ProductionDatabase("sqlite:////nonexistent/folder/production.sqlite")


def test_sqlite_writes_ahead_and_keeps_foreign_keys(tmp_path):
    url = f"sqlite:///{tmp_path}/production.sqlite"
    database = ProductionDatabase(url)
    with database._engine.connect() as connection:
        assert connection.exec_driver_sql("PRAGMA journal_mode").scalar() == "wal"
        assert connection.exec_driver_sql("PRAGMA foreign_keys").scalar() == 1
    database.close()


def test_two_programs_may_open_a_new_database_at_once(url):
    with ThreadPoolExecutor(4) as pool:
        for database in pool.map(ProductionDatabase, [url] * 4):
            database.close()
    assert execute(url, "SELECT version_num FROM alembic_version") == [(NEWEST,)]


@pytest.mark.parametrize(
    "url", ["nonsense", "oracle9://x", "postgresql+psycopg2://u:secret@/d?host=/no"]
)
def test_a_url_that_is_none_is_an_order_error_without_its_password(url):
    with pytest.raises(OrderError, match="database ") as caught:
        ProductionDatabase(url)
    assert "secret" not in str(caught.value)
