"""The cell's abilities are those of the table in remodel_msgs."""

from remodel_skills.abilities.ability import cell_abilities
from remodel_states.edge.exported_tables import read_abilities


def test_the_cell_does_every_ability_of_the_table():
    rows = [row.name for row in read_abilities().values() if row.package == "remodel_msgs"]
    assert sorted(cell_abilities()) == sorted(rows)
