"""create_ability refuses names that cannot be used, and writes nothing then."""

from pathlib import Path

import pytest

from remodel_states.commands.create_ability import main
from remodel_states.commands.generate_states import main as generate_states
from remodel_states.core.state_source import package_files


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (["crimp"], "ability 'crimp': allowed: a verb and a noun such as CrimpFerrule"),
        (["CrimpFerrule", "--package", "Crimp"], "package 'Crimp': allowed: lower case"),
        (["InsertCable", "--package", "own"], "there is an ability InsertCable already"),
        (["CrimpFerrule", "--package", "remodel_sim"], "there is a package remodel_sim already"),
    ],
)
def test_names_that_cannot_be_used_are_refused(tmp_path, capsys, words, problem):
    assert main([*words, "--into", str(tmp_path)]) == 1
    assert problem in capsys.readouterr().err
    assert not [*tmp_path.iterdir()]


def test_a_folder_that_exists_is_left_alone(tmp_path, capsys):
    assert main(["CrimpFerrule", "--into", str(tmp_path)]) == 0
    assert main(["CrimpFerrule", "--into", str(tmp_path)]) == 1
    assert "crimp_ferrule exists already; choose another place by --into" in capsys.readouterr().err


def test_a_state_that_is_out_of_date_is_reported_and_written_again(tmp_path, capsys):
    main(["CrimpFerrule", "--into", str(tmp_path)])
    folder = tmp_path / "crimp_ferrule"
    table = folder / "config" / "abilities.yaml"
    assert generate_states(["--check", str(folder)]) == 0
    table.write_text(table.read_text().replace("force_limit: 8.0", "force_limit: 9.0"))
    assert generate_states(["--check", str(folder)]) == 1
    assert "out of date" in capsys.readouterr().out
    assert generate_states([str(folder)]) == 0
    assert generate_states(["--check", str(folder)]) == 0
    table.write_text(table.read_text().replace("[target_id]", "[target]"))
    assert generate_states([str(folder)]) == 1
    assert "state.inputs: target is not a field of the goal" in capsys.readouterr().err


def test_a_folder_that_is_no_package_is_reported(tmp_path, capsys):
    assert generate_states([str(tmp_path)]) == 1
    assert "give the folder of a package" in capsys.readouterr().err
    (tmp_path / "package.xml").write_text("<package")
    assert generate_states([str(tmp_path)]) == 1
    assert "package.xml: 1 problem:\n  - it is not XML" in capsys.readouterr().err


def test_templates_are_filled_in_paths_and_texts():
    files = package_files({"action/@ability@.action.in": "@title@ @number@"}, "FeedWire", "x", 1001)
    assert files == {str(Path("action/FeedWire.action")): "Feed Wire 1001"}
