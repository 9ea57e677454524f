"""What can be wrong with a test itself."""


class CaseError(Exception):
    """A test case that cannot be run; the text says why."""
