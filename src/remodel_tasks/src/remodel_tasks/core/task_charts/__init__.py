"""The tasks of a plan as state charts.

task_chart     a decomposed task as a state chart, with the recovery that the use case asks for
planned_tasks  the tasks of a plan in their order, with their charts, and what these demand
"""
