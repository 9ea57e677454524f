"""Use cases as data: what kinds of task there are, and how each decomposes into actions.

model    a use case: characteristics, what is unknown, abilities, actions, methods, rules
reading  a use case from its parsed document, with all names checked
fault    the kinds of faults, and a use case's responses to each
"""
