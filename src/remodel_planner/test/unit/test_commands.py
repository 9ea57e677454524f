"""The command lines refuse bad input with a reason, and leave nothing behind."""

import shutil
from pathlib import Path

import pytest

from remodel_planner.commands import import_design, run_order
from remodel_planner.edge.production_database import ProductionDatabase
from remodel_planner.errors import OrderError

DESIGN = Path("/usr/share/qelectrotech/examples/tableau_domestique.qet")


@pytest.fixture
def database(tmp_path):
    return f"sqlite:///{tmp_path}/production.sqlite"


def refused_import(file, database, capsys):
    """Import what can't be imported; return what is said, the order being nowhere."""
    assert import_design.main([str(file), "--order", "house", "--database", database]) == 1
    with pytest.raises(OrderError, match="no order house"):
        ProductionDatabase(database).order("house")
    return capsys.readouterr().err


def test_a_design_is_imported_once(database, capsys):
    arguments = [str(DESIGN), "--order", "house", "--database", database]
    assert import_design.main(arguments) == 0
    assert "58 wires lie in the cabinet" in capsys.readouterr().out
    assert import_design.main(arguments) == 1
    assert "has an order house already: give another name" in capsys.readouterr().err


def test_a_missing_file_is_named(tmp_path, database, capsys):
    said = refused_import(tmp_path / "no.qet", database, capsys)
    assert f"{tmp_path}/no.qet: cannot be read: No such file or directory" in said


def test_a_design_that_is_no_xml_is_refused_with_its_line(tmp_path, database, capsys):
    file = tmp_path / "noise.qet"
    file.write_text("<project>\n  <diagram>\n</project>")
    said = refused_import(file, database, capsys)
    assert f"{file}: " in said
    assert "line 3" in said


def test_a_file_of_another_kind_is_refused(tmp_path, database, capsys):
    file = tmp_path / "picture.qet"
    shutil.copy(Path(__file__), file)
    assert f"{file}: " in refused_import(file, database, capsys)


def test_an_unknown_order_is_refused_before_anything_starts(database, capsys):
    assert run_order.main(["nowhere", "--database", database]) == 2
    assert "the database has no order nowhere; it has: none" in capsys.readouterr().err


def test_no_wires_is_wrong_usage(database, capsys):
    with pytest.raises(SystemExit) as exit_info:
        run_order.main(["house", "--wires", "0", "--database", database])
    assert exit_info.value.code == 2
    assert "--wires must be at least 1, found 0" in capsys.readouterr().err
