"""What can go wrong with a command."""


class CommandError(Exception):
    """A command cannot be carried out; the message is the answer to whoever gave it."""


class PictureError(ValueError):
    """A picture of a camera cannot be shown."""
