"""A run of an order as a sequence of events: its state and the next step follow from them alone.

events.py       what happens in a run, and events as plain data, for the database
state.py        what is known of a run, its snapshot, and what clients that keep a copy are sent
sums.py         what each task counts for, the sums of a run, and statistics of several
step.py         what comes next, for a state
transitions.py  how each event changes the state
attempts.py     the behaviors of a run
entries.py      how events read to a person
event_table.py  what each event means: the table of all three, and the views that follow from it
gate.py         the one gate through which everything passes that moves
replay.py       a recorded run played back, and compared
steady_clock.py ROS time without the jumps of /clock
"""
