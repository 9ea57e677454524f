"""The two supervisors, over ports: no ROS, no threads, no disk.

ports.py                what they need of the world, as protocols, and what a run is about
use_case_supervisor.py  takes a run to its end: does what core/runs derives from the events
run_record.py           keeps the events of a run
run_control.py          does what operators and safety controllers ask of a run, and says when it
                        is allowed, and answered
gate_keeper.py          closes and opens the gate; claims tasks, keeps the lease of the one under
                        way; stops what runs, and waits for what was lost
task_executor.py        has the cell build the panel, runs behaviors, inspects what is done
task_supervisor.py      runs one behavior, grants its operations, keeps what they did
failure_judge.py        decides about failures, asks operators
cell_runs.py            the node without ROS: acquires the cell, resumes the run that was cut short,
                        and supervises the runs that goals ask for, one after the other
run_commands.py         passes commands to the run under way, or to one that cannot be resumed;
                        holds the cell between runs

Everything happens on one thread, in `EventLoop.run_until`: records, permissions, commands and
timers arrive while a supervisor waits for something else. ros/ has the ports of a real cell,
test/schedules those of a simulated one, in which thousands of schedules of kills, stalls and
commands run in minutes.
"""
