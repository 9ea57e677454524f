"""The two supervisors, over ports: no ROS, no threads, no disk.

ports.py                what they need of the world, as protocols, and what a run is about
use_case_supervisor.py  takes a run to its end: does what core/runs derives from the events
run_record.py           keeps the events of a run
run_control.py          does what operators and safety controllers ask of a run, and says when it
                        is allowed, and answered
gate_keeper.py          closes and opens the gate
leases.py               claims tasks, keeps the lease of the one under way
task_executor.py        has the cell build the panel, runs behaviors, inspects what is done
task_supervisor.py      runs one behavior, grants its operations, keeps what they did
reconnection.py         stops what runs, and waits for what was lost
failure_judge.py        decides about failures, asks operators
cell/                   the runs of one cell, one after the other

Everything happens on one thread, in `EventLoop.run_until`: records, permissions, commands and
timers arrive while a supervisor waits for something else. ros/ has the ports of a real cell,
test/schedules those of a simulated one, in which thousands of schedules of kills, stalls and
commands run in minutes.
"""
