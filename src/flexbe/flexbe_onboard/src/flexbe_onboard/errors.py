"""What the engine cannot do, and why."""


class StartError(Exception):
    """A start request that cannot be granted; the text says why and what to do."""


class OptionError(ValueError):
    """A parameter of the node makes no sense."""
