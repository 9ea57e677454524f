"""Ability servers without a robot, for tests and dry runs.

A fake cell: all abilities over one physical world that outlives their processes (node fake_cell).

world.py           what lies, is held, and sits where; and what was done
operations.py      what each ability asks of the world before it moves, and does to it
faults.py          what goes wrong, when, and what cures it
world_file.py      the world on disk, shared by processes
cell_ability.py    one ability's action server, its course in time, the lock of its robot; the
                   server FakeAbility, whose answers are scripted, at once or never
cell_services.py   feeder, panel, pictures, faults and the truth
"""

from remodel_states.testing.cell_ability import FakeAbility, FakeAnswer, serve_all

__all__ = ["FakeAbility", "FakeAnswer", "serve_all"]
