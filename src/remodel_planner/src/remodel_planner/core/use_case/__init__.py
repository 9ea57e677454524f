"""Use cases as data: what kinds of task there are, and how each decomposes into actions.

model          a use case: characteristics, what is unknown, abilities, actions, methods, rules
reading        a use case from its parsed document, with all names checked
expectation    how long abilities take and how often they succeed: where learning plugs in
work_order     what is to be done: components, terminals and tasks, without durations
decomposed     a task taken apart: its steps, and what was rejected for them
decomposition  a task into macro operations and actions, by methods, on what is known
requirements   what requirements forbid to decompositions
wiring_problem the decomposed tasks as the problem that core/planning solves
preparation    an order made ready for planning
outline        a decomposition in words
task_values    what the inputs and parameters of a task's states can refer to
task_chart     a decomposed task as a state chart, with the recovery that the use case asks for
planned_tasks  the tasks of a plan in their order, with their charts
"""
