"""Learn from runs what abilities can do, and with which parameters they do it best.

    belief.py      success and duration by context, with their uncertainty: general contexts lend
                   to special ones; which setting of parameters to try next, within a guard rail
    experience.py  what all runs have taught about abilities, parameters and responses to faults,
                   for one use case, as a supervisor asks for it

All models are computed from records in their order: the same records give the same model.
"""
