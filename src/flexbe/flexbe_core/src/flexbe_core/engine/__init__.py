"""The engine: pure Python, with no ROS, clock, thread, disk or log.

Read in this order: engine (how a driver uses it), node (the runtime nodes), leaf, machine,
concurrency, priority (what each kind does), supervision.decision (what a state may do),
supervision.apply_commands (what each command changes). supervision.commands is the input, events
the output.
"""
