"""Why a behavior is not asked for."""


class RequestError(Exception):
    """A request that makes no sense; the text says what was found, what there is, what to do."""
