"""What can go wrong with a command."""


class CommandError(Exception):
    """A command cannot be carried out; the message is the answer to its sender."""


class PictureError(ValueError):
    """A picture of a camera cannot be shown."""
