"""What to do when a task fails: which fault it was, and how the policy responds to it.

judge.py      which fault a task failed with, and what is done about it
failure.py    one failure of a task, with all that is known about it
decide.py     failure, what was done before, and policy -> decision, with its reason
changed_parameters.py  the chart of a task that is tried again with other parameters
question.py   what an operator is asked
notice.py     what persons who are not at the console are notified of
"""
