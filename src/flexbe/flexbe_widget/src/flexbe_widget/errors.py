"""Errors of the tools of this package."""


class RequestError(Exception):
    """An invalid request; the text says what was found, what there is, what to do."""


class LogError(Exception):
    """A run log that cannot be read."""


class RepositoryError(Exception):
    """A repository that cannot be made."""
