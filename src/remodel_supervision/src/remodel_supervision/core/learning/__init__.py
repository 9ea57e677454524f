"""Learn from runs what abilities can do, and with which parameters they do it best.

    belief.py                a probability of success, with its uncertainty
    success_model.py         success by context; general contexts lend to special ones
    duration_model.py        duration by context, in the same manner
    learned_expectations.py  both, in place of what a use case states
    parameter_choice.py      which setting of parameters to try next, within a guard rail
    learned_parameters.py    the same for all abilities, from recorded calls
    learned_responses.py     which responses to a fault are worth trying
    experience.py            all of it for one use case, as a supervisor asks for it

All models are computed from records in their order: the same records give the same model.
"""
