"""The runs of one cell, one after the other: the node without ROS.

owned_cell.py      acquires the cell, and renews the lease on it
cell_runs.py       resumes the run that was cut short, and supervises the runs that goals ask for
run_commands.py    passes commands to the run under way, or to one that cannot be resumed; holds the
                   cell between runs
"""
