"""Curves in a picture: polylines and splines, and robust statistics of their samples."""
