"""Does an ability server keep the contract of all abilities (Deliverable 5.1, 3.1)?

goals.py     the goals that are sent: a good one, and bad ones made from it
exchange.py  what was heard about one goal
rules.py     what is wrong with it: pure, one function per clause of the contract
probe.py     sends goals and listens
trial.py     which goals are sent when, and what each is judged by
report.py    the findings in words, and as JSON
"""
