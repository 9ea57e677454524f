"""Steps that observe: from where, what is visible, and whether a wire lies where it should."""
