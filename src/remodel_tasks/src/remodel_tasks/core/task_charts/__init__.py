"""The tasks of a plan as state charts.

task_chart     a decomposed task as a state chart, with the recovery that the use case asks for
task_values    what the inputs and parameters of a task's states can refer to
demands        what charts demand of a cell
escalation     a chart that leaves faults to levels above its behavior
planned_tasks  the tasks of a plan in their order, with their charts
"""
