"""Files of the calibration."""
