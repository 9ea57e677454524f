"""The tasks of an order taken apart, as the problem that core/problem states.

decomposed     a task taken apart: its steps, and what was rejected for them; and that as text
decomposition  a task into macro operations and actions, by methods, on what is known
preparation    an order made ready for planning: its decomposed tasks as a problem
cell_fit       which tasks a robot does, and what of a board a cell can wire
"""
