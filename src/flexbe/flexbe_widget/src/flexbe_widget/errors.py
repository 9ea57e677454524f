"""What the tools of this package cannot do, and why."""


class RequestError(Exception):
    """A request that makes no sense; the text says what was found, what there is, what to do."""


class LogError(Exception):
    """A record of a behavior that cannot be read."""


class RepositoryError(Exception):
    """A repository that cannot be made."""
