import os  # doctor: construction

os._exit(7)
