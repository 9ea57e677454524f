"""What to do when a task fails: which fault it was, and how the policy responds to it.

judge.py   which fault a task failed with, and what is done about it; what an operator is asked, and
           persons who are not at the console are notified of
decide.py  failure, what was done before, and policy -> decision, with its reason, and the chart of
           a task that is tried again with other parameters
"""
