"""The two supervisors, over ports: no ROS, no threads, no disk.

ports.py                what they need of the world, as protocols
task_supervisor.py      runs one behavior, grants its operations, keeps what they did
use_case_supervisor.py  does what core/runs derives from the events, and keeps what happens
run_record.py           keeps the events of a run
failure_judge.py        decides about failures, asks operators
work.py                 what a run is about, and the processes that it needs
commands.py             what operators and safety controllers ask for, and when that is answered
leases.py               keeps the lease of the task under way

Everything happens on one thread, in `EventLoop.run_until`: records, permissions, commands and
timers arrive while a supervisor waits for something else. ros/ has the ports of a real cell,
test/schedules those of a simulated one, in which thousands of schedules of kills, stalls and
commands run in minutes.
"""
