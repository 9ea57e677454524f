"""What can be wrong with a calibration."""


class CalibrationError(Exception):
    """The views cannot be used; the text says which, what was found and what to do."""
