"""What can stop a synthesis besides mistakes in a chart."""


class SynthesisError(RuntimeError):
    """Base of the errors below; the message is meant for the user."""


class ChartFileError(SynthesisError):
    """A chart's file cannot be read."""


class ChartRefusedError(ChartFileError):
    """A chart's path leads out of the folders that charts may be in."""


class OutputError(SynthesisError):
    """A behavior cannot be written where it belongs."""


class DrawingError(SynthesisError):
    """A drawing cannot be made."""
