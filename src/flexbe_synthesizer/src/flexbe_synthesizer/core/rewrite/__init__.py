"""A chart changed inside the text of its file; all else stays byte for byte."""
