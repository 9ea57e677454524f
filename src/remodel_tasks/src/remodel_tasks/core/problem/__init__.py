"""The wiring of a panel as a problem: which wire when, by which arm, from which end.

problem      what is to be done, how far it is, and in which modes; instance reads and writes it
preferences  what a user wants besides; conflict: which requirements contradict each other
defects      what makes a problem impossible to plan, found before planning
part         the problem of some of the tasks, and its cables
"""
