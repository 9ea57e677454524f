"""Why a behavior is not started."""


class StartError(Exception):
    """A start request that cannot be granted; the text says why and what to do."""
