"""Use cases as data: what kinds of task there are, and how each decomposes into actions.

model          a use case: characteristics, what is unknown, abilities, actions, methods, rules
reading        a use case from its parsed document, with all names checked
expectation    how long abilities take and how often they succeed: where learning plugs in
work_order     what is to be done: components, terminals and tasks, without durations
decomposition  a task into macro operations and actions, by methods, on what is known
requirements   what requirements forbid to decompositions
wiring_problem the decomposed tasks as the problem that core/planning solves
preparation    an order made ready for planning
task_chart     a decomposed task as a state chart, with the recovery that the use case asks for
"""
