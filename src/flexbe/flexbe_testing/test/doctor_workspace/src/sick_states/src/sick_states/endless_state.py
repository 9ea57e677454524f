import threading  # doctor: construction

threading.Event().wait()
