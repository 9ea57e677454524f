"""Learn from runs what abilities can do, and with which parameters they do it best.

    belief.py            a probability of success, with its uncertainty
    success_model.py     success by context: ability, terminal, gauge, ...; general contexts lend to
                         special ones
    duration_model.py    duration by context, in the same manner
    parameter_choice.py  which value of a parameter to try next, within a guard rail

All models are folds over records in their order: the same records give the same model.
"""
