"""What a KBL harness has besides its wires and their connectors."""
