"""Planning the wiring of a panel: which wire when, by which arm, from which end.

problem      what is to be done, and how far it is; instance and plan_form read and write it
preferences  what a user wants besides; choices tell of which wires
defects      what makes a problem impossible to plan, found before planning
tables       the problem as arrays of integers, as the kernel takes it
decoder      the plain reference of the kernel: what the arms do with a list of wires
annealing    how much the search does at which temperature, for a limit of time
progress     the problem that is left when part of a plan is executed, and something has failed
checker      the judge of plans, which shares no code with the search
explanation  a plan in words; drawing draws it
symbolic     the problem in symbols, which pddl and hddl write
"""
