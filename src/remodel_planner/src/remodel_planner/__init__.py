"""From production knowledge to tasks, charts and finished wires."""
