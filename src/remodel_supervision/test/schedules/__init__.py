"""Deterministic simulation of schedules: the real supervisors over a world that is made up.

Everything runs in one process, on one thread, over one clock and one heap of events; all that is
left to chance comes from one seed. Real are the supervisors with their state machine, the run log,
the task leases and the ownership of cells over SQLite. Simulated are time, messages, the engine,
the ability servers, the cell, and people.

simulation.py  clock, events, chance, trace
node.py        a process that can be killed, stalled and restarted
process.py     a supervisor's process: a greenlet, and its event loop
site.py        the world that cells share, who moves in it, and the ledger
server.py      an ability server; cell_services.py: feeder and panel; engine.py: behaviors
ports.py       the supervisors' ports to all of them
database.py    a database in memory that fails, and whose clock is simulated
planner.py     an order, its plan, and charts for the simulated engine
station.py     a robot with its processes; life.py: of its supervisor, as ros/server/run_server.py
disturbances.py  what goes wrong, drawn by a seed
people.py      who sends goals, answers questions, and resumes
invariants.py  what must hold, whatever happens
schedule.py    one schedule from its seed to its verdict
__main__.py    many of them

It is part of the tests since the world of the fake cell is that of remodel_states, which the
planner does not import.
"""
