"""The wiring of a panel as a problem: which wire when, by which arm, from which end.

problem      what is to be done, and how far it is; instance and plan_form read and write it
preferences  what a user wants besides; choices names the wires
defects      what makes a problem impossible to plan, found before planning
order, modes the order of a plan's wires, and how each is done; opening: a first order
part         the problem of some of the tasks
"""
