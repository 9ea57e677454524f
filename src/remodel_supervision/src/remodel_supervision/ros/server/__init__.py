"""The supervisor's node: its actions, services and topics."""
