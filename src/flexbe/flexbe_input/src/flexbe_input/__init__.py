"""Questions of states to the operator, and his answers."""
