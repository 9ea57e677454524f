"""A run of an order as a row of events: what is known, and what comes next, follow from them alone.

events.py      what happens in a run
event_form.py  events as plain data, for the database
state.py       what is known of a run
fold.py        what is known after some events
step.py        what comes next, for a state
attempts.py    the behaviors of a run, as its events tell of them
picture_name.py  names of a run's pictures
replay.py      a recorded run played back, and compared
"""
