"""The tasks of an order taken apart, as the problem that core/problem states.

decomposed     a task taken apart: its steps, and what was rejected for them
decomposition  a task into macro operations and actions, by methods, on what is known
requirements   what requirements forbid to decompositions
wiring_problem the decomposed tasks as a problem
preparation    an order made ready for planning
outline        a decomposition as text
"""
