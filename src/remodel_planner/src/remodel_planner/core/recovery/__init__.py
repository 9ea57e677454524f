"""What to do when a task fails: which fault it was, and what the policy answers to it.

fault.py      the kinds of faults, and which one an error code tells of
failure.py    one failure of a task, with all that is known about it
policy.py     responses to each fault, and limits
decide.py     failure, what was done before, and policy -> decision, with its reason
"""
