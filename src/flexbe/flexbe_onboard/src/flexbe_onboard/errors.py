"""Errors of the engine."""


class StartError(Exception):
    """A start request cannot be granted; the text says why and what to do."""


class OptionError(ValueError):
    """A parameter of the node is invalid."""
