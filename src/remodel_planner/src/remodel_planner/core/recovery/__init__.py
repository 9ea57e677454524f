"""What to do when a task fails: which fault it was, and how the policy responds to it.

fault.py      the kinds of faults, and which one an error code belongs to
failure.py    one failure of a task, with all that is known about it
policy.py     responses to each fault, and limits
decide.py     failure, what was done before, and policy -> decision, with its reason
notice.py     what somebody who is not at the console is notified of
"""
