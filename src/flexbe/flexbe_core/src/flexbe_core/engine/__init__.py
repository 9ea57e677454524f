"""The engine: pure Python, with no ROS, clock, thread, disk or log.

Read in this order: engine (how a driver uses it), leaf (the runtime nodes), containers (what each
kind does), supervision (what an operator may ask, and what a state may do then). Commands are
the input, events the output.
"""
