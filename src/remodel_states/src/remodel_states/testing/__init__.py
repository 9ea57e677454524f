"""Ability servers without a robot, for tests and dry runs.

fake_ability.py    one server with scripted answers, at once or never

A fake cell: all abilities over one physical world that outlives their processes (node fake_cell).

world.py           what lies, is held, and sits where, as a value
requirements.py    what each ability asks of the world before it moves
operations.py      what each ability does to the world
faults.py          what goes wrong, when, and what cures it
ledger.py          what was done that cannot be undone, and the account of it
world_file.py      the world on disk, shared by processes
robot_lock.py      one goal at a time, over processes
course.py          how long an operation takes, and when it takes effect
panel.py           the world's panel of a message, and poses back
cell_ability.py    one ability's action server
cell_services.py   feeder, panel, pictures, faults and the truth
"""

from remodel_states.testing.fake_ability import FakeAbility, FakeAnswer, serve_all

__all__ = ["FakeAbility", "FakeAnswer", "serve_all"]
