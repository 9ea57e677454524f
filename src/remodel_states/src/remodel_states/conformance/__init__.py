"""Does an ability server keep the contract of all abilities (Deliverable 5.1, 3.1)?

clauses.py  what the contract requires, and what is tried
rules.py    what was heard about one goal, and what is wrong with it: one function per clause
probe.py    sends goals, a good one and bad ones made from it, and listens
trial.py    which goals are sent when, what each is judged by, and the findings
"""
