"""Files, and the cluster."""
