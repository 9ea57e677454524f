"""Record what the wrist feels in every push and pull, at each step of the physics, not filtered."""

from contextlib import contextmanager
from dataclasses import dataclass, field

from remodel_sim.physics.robot import Robot
from remodel_skills.force_control import ForceLoop

# The force is recorded for so long after the last command of a push [s].
AFTER_S = 0.05


@dataclass
class ForceRecord:
    """One push or pull, as long as it keeps to one limit.

    Attributes:
        limit: its force limit [N].
        loop: what controls it.
        forces: on the hand against the motion, of each step [N].
        low_passed: the same, as the sensor says [N].
        since_s: time since the last command [s].
    """

    limit: float
    loop: ForceLoop
    forces: list[float] = field(default_factory=list)
    low_passed: list[float] = field(default_factory=list)
    since_s: float = 0.0

    @property
    def peak(self) -> float:
        """The largest force, not filtered [N]."""
        return max(self.forces, default=0.0)

    @property
    def allowed(self) -> float:
        """What the peak may be [N]."""
        return 1.15 * self.limit + 0.5


@contextmanager
def recorded():
    """Record pushes and pulls; yields the list of them, which grows."""
    records = []
    current = {}
    drive_by, sense = Robot.drive_by, Robot._sense

    def begin(robot, controller):
        loop = controller.__self__
        limit, now = loop.control.limit, current.get(robot)
        if now is None or now.loop is not loop or now.limit != limit:
            current[robot] = ForceRecord(limit, loop)
            records.append(current[robot])
        current[robot].since_s = 0.0
        drive_by(robot, controller)

    def record(robot):
        sense(robot)
        now = current.get(robot)
        if now is None or now.since_s > AFTER_S:
            return
        now.since_s += robot._time_step
        rotation = robot.world_from_hand.rotation
        for felt, to in ((robot.read_wrist(), now.forces), (robot.wrist_force, now.low_passed)):
            to.append(float((rotation @ felt - now.loop.free) @ now.loop.along))

    Robot.drive_by, Robot._sense = begin, record
    try:
        yield records
    finally:
        Robot.drive_by, Robot._sense = drive_by, sense
