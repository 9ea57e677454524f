"""A run of an order as a sequence of events: its state and the next step follow from them alone.

events.py      what happens in a run
event_form.py  events as plain data, for the database
state.py       what is known of a run
sums.py        what each task counts for, and the sums of a run
step.py        what comes next, for a state
transitions.py how each event changes the state
attempts.py    the behaviors of a run
entries.py     how events read to a person
event_table.py what each event means: the table of all three, and the views that follow from it
picture_name.py  names of a run's pictures
gate.py        the one gate through which everything passes that moves
gate_decision.py  what the gate is to do and why
replay.py      a recorded run played back, and compared
"""
