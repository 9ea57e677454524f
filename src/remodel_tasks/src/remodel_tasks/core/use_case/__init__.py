"""Use cases as data: what kinds of task there are, and how each decomposes into actions.

model        a use case: characteristics, what is unknown, abilities, actions, methods, rules
reading      a use case from its parsed document, with all names checked
expectation  how long abilities take and how often they succeed: where learning plugs in
bounds       which values of an ability's parameter are safe; context: what success may depend on
fault        the kinds of faults; policy: responses to each, and limits
designs      which designs a use case is for
"""
