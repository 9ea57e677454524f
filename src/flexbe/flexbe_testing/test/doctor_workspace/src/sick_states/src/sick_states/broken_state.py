from flexbe_core import EventState


class BrokenState(EventState:  # doctor: syntax
    pass
