"""Parameters of states that need a check or a conversion before they fit into a goal."""
