"""Autonomy levels."""


class Autonomy:
    """How much a transition needs.

    A transition is taken without asking if its level is below the behavior's.
    """

    Inherit = 0
    Off = 0
    Low = 1
    High = 2
    Full = 3
