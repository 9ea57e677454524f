"""The engine: pure Python, with no ROS, clock, thread, disk or log.

Read in this order: engine (what drives it), node (what a record of a run is), leaf, machine,
concurrency, priority (what each kind does), decision (what supervision allows), obey (what each
command changes). commands and facts are what goes in and comes out.
"""
