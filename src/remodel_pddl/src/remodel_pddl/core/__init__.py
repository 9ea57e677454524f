"""The problem in symbols, which pddl and hddl write."""
