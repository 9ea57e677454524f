"""The people of a schedule: they send goals, command, answer questions, and resume."""

from __future__ import annotations

from collections.abc import Sequence

from remodel_run.progress import Answer
from remodel_supervision.core.runs.events import Answered, Command, Commanded
from remodel_supervision.core.runs.state import RunState
from schedules.invariants import Invariants
from schedules.simulation import Simulation
from schedules.site import Site
from schedules.station import Station

# [s] between two looks at the console.
_CHECK_S = 0.9


class People:
    """Everybody who has a say.

    Attributes:
        is_done: whether the order is done, and no person acts any more.
    """

    def __init__(
        self,
        simulation: Simulation,
        site: Site,
        stations: Sequence[Station],
        invariants: Invariants,
        count: int,
        calm_s: float,
        again_s: float | None,
    ) -> None:
        """Begin to work.

        Args:
            simulation: of the schedule.
            site: whose faults can be mended.
            stations: where they work.
            invariants: that check what they hear.
            count: of the tasks that they want done.
            calm_s: [s] from when on they only help.
            again_s: [s] when they want the next product; None if they do not.
        """
        self.is_done = False
        self._simulation = simulation
        self._site = site
        self._stations = stations
        self._invariants = invariants
        self._count = count
        self._calm_s = calm_s
        self._again_s = again_s
        self._paused_until_s: dict[str, float] = {}
        self._answered: dict[str, tuple[int, int]] = {}
        self._resumed_s: dict[str, float] = {}
        self._is_waiting_for_goal: set[str] = set()
        for station in stations:
            simulation.after(simulation.random.uniform(0.1, 5.0), self.send_goal, station)
        simulation.after(_CHECK_S, self._check)

    @property
    def is_calm(self) -> bool:
        return self._simulation.now_s > self._calm_s

    def send_goal(self, station: Station, *, again: bool = False) -> None:
        def on_answer(why_not: str | None) -> None:
            self._is_waiting_for_goal.discard(station.name)
            self._simulation.note("people", "goal at {}: {}", station.name, why_not or "accepted")

        self._is_waiting_for_goal.add(station.name)
        self._resumed_s[station.name] = self._simulation.now_s
        self._invariants.on_goal(station)
        station.send_goal(self._count, on_answer, again=again)

    def command(self, station: Station, command: Command, task: str = "") -> None:
        event, sent_s = Commanded(command, task, "ann"), self._simulation.now_s
        if command is Command.RESUME:
            self._invariants.on_resume(station)
        resumes_s = self._resumed_s.get(station.name, -1.0)

        def on_answer(granted: bool) -> None:
            is_resumed = self._resumed_s.get(station.name, -1.0) != resumes_s
            if granted and not is_resumed:
                self._invariants.on_reply(station, event, sent_s)

        if command is Command.RESUME:
            self._resumed_s[station.name] = sent_s
        station.command(event, on_answer)

    def pause(self, station: Station, command: Command, for_s: float) -> None:
        """Pause, or stop protectively, and resume after a time [s]."""
        until_s = self._simulation.now_s + for_s
        self._paused_until_s[station.name] = max(
            until_s, self._paused_until_s.get(station.name, 0.0)
        )
        self.command(station, command)

    # --- what they do by themselves

    def _check(self) -> None:
        for station in self._stations:
            supervisor = station.supervisor
            if supervisor is None:
                self._release(station)
            else:
                self._help(station, supervisor.state, supervisor.run)
        if all(s.supervisor is None for s in self._stations):
            self._check_runs()
        elif self._again_s is None:
            self._check_for_idle()
        if not self.is_done:
            self._simulation.after(_CHECK_S, self._check)

    def _release(self, station: Station) -> None:
        """Release a protective stop that holds a cell without a run, or have one go on."""
        if station.process is None or station.life is None:
            return
        is_over = self._simulation.now_s > self._paused_until_s.get(station.name, 0.0)
        is_stuck = station.life.commands.unresumed is not None
        if is_stuck and self._simulation.chance(0.2):
            self.command(station, Command.STOP)
        elif is_over and (is_stuck or station.stopped_by):
            self.command(station, Command.RESUME)

    def _help(self, station: Station, state: RunState, run: int) -> None:
        now_s = self._simulation.now_s
        if state.paused and now_s > self._paused_until_s.get(station.name, 0.0):
            self.command(station, Command.RESUME)
        asked = state.question
        is_new = asked is not None and self._answered.get(station.name) != (run, asked.number)
        patient = 0.5 if self.is_calm else 0.1
        if asked is None or not (is_new or self._simulation.chance(patient)):
            return
        if self._simulation.chance(0.5):
            self._answered[station.name] = run, asked.number
            choice = self._choice(state, asked.task, asked.choices)
            station.answer(Answered(asked.number, choice, "ann"), lambda _: None)

    def _choice(self, state: RunState, task: str, choices: Sequence[Answer]) -> Answer:
        if self.is_calm:
            self._site.mend()
            useful = (Answer.FIXED, Answer.RETRY, Answer.SKIP, Answer.REPLAN)
            choices = [choice for choice in choices if choice in useful]
        choice = self._simulation.random.choice(tuple(choices))
        world = self._site.world
        is_there = world.panel.serial == state.serial and world.is_placed(task)
        if choice is Answer.MARK_DONE and not is_there:
            return Answer.SKIP
        if choice is Answer.FIXED:
            self._site.mend()
        return choice

    def _check_for_idle(self) -> None:
        """Have a station help that has no run while another one has."""
        if self.is_calm:
            return
        for station in self._stations:
            is_open = station.process is not None and station.supervisor is None
            if is_open and self._simulation.chance(0.1):
                self.send_goal(station)

    def _check_runs(self) -> None:
        """No run of the order is under way: request the rest of it, until all of it is done."""
        states = self._invariants.states
        known = [state.ended is not None for state in states.values()]
        if not (known and all(known)) or self.is_calm:
            self._invariants.read_open_runs()
        if not states:
            if self._simulation.chance(0.5):
                self.send_goal(self._simulation.random.choice(self._stations))
            return
        is_open = any(state.ended is None for state in states.values())
        is_complete = not is_open and self._is_complete(states[max(states)])
        if is_complete and self._again_s is not None and not self.is_calm:
            self._again_s = None
            self.send_goal(self._stations[0], again=True)
        elif is_complete and self.is_calm:
            self.is_done = True
        elif not is_complete and self._simulation.chance(0.5):
            self._send_next_goal()

    def _send_next_goal(self) -> None:
        if self.is_calm and not self._is_waiting_for_goal:
            self._site.mend()
            self._site.faults = ()
        self.send_goal(self._simulation.random.choice(self._stations))

    @staticmethod
    def _is_complete(state: RunState) -> bool:
        return all(task.stage.value == "done" for task in state.tasks.values())
