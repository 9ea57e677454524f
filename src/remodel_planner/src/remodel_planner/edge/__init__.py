"""The files of reports."""
