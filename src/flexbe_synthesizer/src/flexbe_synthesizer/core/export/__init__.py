"""What a chart becomes for others: Python, states for the App, certificate, picture, SCXML."""
