"""Turn a decomposed task into its state chart, with the recovery that the use case asks for.

Each step becomes a state, or a behavior that exists, and goes on to the next one. What fails is
tried again as often as its action says, or sends the task back to the action that it names. What
is given up ends in the use case's `give_up` actions, so that all hands are empty when the task
failed.
What the task says about itself stands in the chart's inputs; what observations reveal flows from
the latest observing state to those that need it.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

from flexbe_synthesizer.core.chart.chart_writer import write_chart
from flexbe_synthesizer.core.chart.model import (
    AnyNode,
    Behavior,
    Chart,
    Connection,
    Input,
    Literal,
    Outcome,
    Output,
    Param,
    State,
    Transition,
)
from remodel_tasks.core.decomposition.decomposed import Decomposition, Step
from remodel_tasks.core.orders.work_order import Task, plain_name
from remodel_tasks.core.problem.problem import End, Point
from remodel_tasks.core.use_case.model import ARM, FORCE, Action, Macro, UseCase
from remodel_tasks.errors import UseCaseError


@dataclass(frozen=True)
class TaskValues:
    """The values of a task.

    Attributes:
        first: the end that is inserted first.
        component_of: components by the names of terminals.
        height_m: of the tool centre while something is carried.
    """

    task: Task
    first: End
    component_of: dict[str, str]
    height_m: float

    def of(self, step: Step, arm: str) -> dict[str, object]:
        """Return what references may name in a step that an arm does."""
        values: dict[str, object] = {
            "task": self.task.name,
            ARM: arm,
            "slot_pose": poses([self.task.slot_mm], self.height_m)[0],
            "path": poses(step.route.path_mm, self.height_m),
            **self._of_end("first_", self.first),
            **self._of_end("second_", self.first.other),
        }
        if self.task.meeting_mm is not None:
            values["meeting_pose"] = poses([self.task.meeting_mm], self.height_m)[0]
        if step.end is not None:
            values |= self._of_end("", step.end)
            values |= {FORCE: step.force_n} if step.action.force_n else {}
            known = {"clearance_m": step.access.clearance_m, "approach": step.access.approach}
            values |= {name: value for name, value in known.items() if value is not None}
        if step.clip is not None:
            values["clip"] = step.clip.name
        return {**values, **dict(self.task.values)}

    def _of_end(self, prefix: str, end: End) -> dict[str, object]:
        terminal = self.task.terminals[end]
        component = self.component_of[terminal]
        return {
            f"{prefix}end": end.letter,
            f"{prefix}component": component,
            f"{prefix}terminal": terminal.removeprefix(f"{component}:"),
        }


def poses(path_mm: Sequence[Point], height_m: float) -> tuple[tuple[float, ...], ...]:
    """Return tool poses [x, y, z, yaw] in the panel frame [m, rad], facing along a path."""
    placed: list[tuple[float, ...]] = []
    for i, (x, y) in enumerate(path_mm):
        if i + 1 < len(path_mm):
            yaw = math.atan2(path_mm[i + 1][1] - y, path_mm[i + 1][0] - x)
        else:
            yaw = placed[-1][3] if placed else 0.0
        placed.append((x / 1e3, y / 1e3, height_m, round(yaw, 4)))
    return tuple(placed)


def step_of(state_path: str) -> str:
    """Return the title of the step of a task that a state is of: the first name in its path."""
    return state_path.strip("/").split("/")[0]


# The outcomes of a task that did what it should, and of one that did not.
FINISHED = "finished"
FAILED = "failed"

_COMMAND_ERROR = "command_error"
_EXHAUSTED = "exhausted"
_ERRORS = (Output("error_code", "int"), Output("error_message", "string"))
_HASH_DIGITS = 16
_MARK = "Content"


def behavior_name(use_case: UseCase, task: str) -> str:
    """Return the name of the behavior that does a task."""
    return use_case.title.replace("{task}", plain_name(task))


def task_chart(
    use_case: UseCase,
    decomposition: Decomposition,
    component_of: dict[str, str],
    arms: tuple[str, ...],
    suffix: str = "",
) -> Chart:
    """Return the chart of a decomposed task.

    Args:
        use_case: of the task.
        decomposition: of the task.
        component_of: components by the names of terminals.
        arms: the arm that begins, and the one that takes over, if one does.
        suffix: of the behavior's name, for a part of the task.

    Raises:
        UseCaseError: if an action refers to a value that the task does not have, or there is none.
    """
    return marked(_Charting(use_case, decomposition, component_of, arms, suffix=suffix).chart())


def marked(chart: Chart) -> Chart:
    """Return a chart whose description ends with a hash of all that the chart says."""
    said = [line for line in chart.description.splitlines() if not line.startswith(_MARK)]
    plain = replace(chart, description="\n".join(said))
    digest = hashlib.sha256(write_chart(plain).encode()).hexdigest()[:_HASH_DIGITS]
    return replace(chart, description="\n".join([*said, f"{_MARK} {digest}."]))


def in_turn(charts: Sequence[Chart]) -> Chart:
    """Return a chart of charts of one state each, whose inputs are the same.

    A state that has finished, or refused, goes on to that of the next chart.
    """
    nodes: list[AnyNode] = []
    connections: list[Connection] = []
    ids = list(numbered(chart.nodes[0].id for chart in charts))
    for chart, new_id, following in zip(charts, ids, [*ids[1:], ""], strict=True):
        (node,) = chart.nodes
        goes_on = (FINISHED, _COMMAND_ERROR) if following else ()
        transitions = tuple(
            replace(each, target=following)
            if each.target in goes_on or each.event in goes_on
            else each
            for each in node.transitions
        )
        nodes.append(replace(node, id=new_id, transitions=transitions))
        connections += [
            replace(each, input_state_id=new_id) if each.input_state_id == node.id else each
            for each in chart.connections
        ]
    return marked(replace(charts[0], nodes=tuple(nodes), connections=tuple(connections)))


def content_mark(chart: Chart) -> str:
    """Return the last line of a task chart's description, a hash of all that the chart says."""
    return chart.description.splitlines()[-1]


def node_ids(steps: Sequence[Step]) -> Iterator[str]:
    """Yield the id of each step's node in the chart of these steps."""
    return numbered(step.title for step in steps)


def numbered(titles: Iterable[str]) -> Iterator[str]:
    """Yield an id for each title; repeated ones are numbered."""
    counts: dict[str, int] = {}
    for title in titles:
        counts[title] = counts.get(title, 0) + 1
        yield title if counts[title] == 1 else f"{title} {counts[title]}"


def emptying(use_case: UseCase, arms: tuple[str, ...]) -> tuple[tuple[Action, str], ...]:
    """Return the actions that empty the hands when a task is given up, each with its arm.

    Each arm of the task does an action of any arm.
    """
    actions = (use_case.actions[name] for name in use_case.give_up)
    return tuple(
        (action, arm)
        for action in actions
        for arm in (dict.fromkeys(arms) if action.is_of_any_arm else arms[:1])
    )


@dataclass(frozen=True)
class _Placed:
    """A step with the id of its node, and the arm that does it."""

    step: Step
    id: str
    arm: str


class _Charting:
    def __init__(
        self,
        use_case: UseCase,
        decomposition: Decomposition,
        component_of: dict[str, str],
        arms: tuple[str, ...],
        suffix: str,
    ) -> None:
        self._use_case = use_case
        self._task = decomposition.task
        height_m = use_case.cell.carry_height_m
        self._values = TaskValues(self._task, decomposition.first, component_of, height_m)
        self._name = behavior_name(use_case, self._task.name) + suffix
        self._placed = tuple(_place(decomposition.steps, arms))
        self._emptying = emptying(use_case, arms)
        self._up_ids = tuple(numbered(action.title for action, _ in self._emptying))
        self._inputs: dict[str, Input] = {}
        self._connections: list[Connection] = []
        self._recoveries: list[State | Behavior] = []

    def chart(self) -> Chart:
        if not self._placed:
            raise UseCaseError(f"task {self._task.name}: there is nothing to do in it")
        nodes = [self._node(index) for index in range(len(self._placed))]
        nodes += self._recoveries
        if any(placed.step.action.grasps for placed in self._placed):
            nodes += self._give_up()
        return Chart(
            name=self._name,
            initial=nodes[0].id,
            outcomes=(Outcome(FINISHED), Outcome(FAILED)),
            inputs=tuple(self._inputs.values()),
            outputs=_ERRORS,
            nodes=tuple(nodes),
            connections=tuple(self._connections),
            description=_describe(self._task, self._use_case),
        )

    def _node(self, index: int) -> State | Behavior:
        placed = self._placed[index]
        action = placed.step.action
        following = self._placed[index + 1].id if index + 1 < len(self._placed) else FINISHED
        up = self._up(index)
        loops = action.attempts > 1
        back = (action.on_failure and self._earlier(index, action.on_failure)) or (
            placed.id if loops else up
        )
        if action.recover:
            back = self._recover(index, back)
        transitions = {**dict.fromkeys(action.done, following), FAILED: back}
        if not action.is_behavior:
            transitions[_COMMAND_ERROR] = up
        if loops:
            transitions[_EXHAUSTED] = up
        revealed = tuple(Output(output) for _, output in action.reveals if output)
        return (Behavior if action.is_behavior else State)(
            id=placed.id,
            type=action.type,
            inputs=(*self._bound(placed), *self._known(index, placed)),
            outputs=(*revealed, *_ERRORS),
            params=self._params(placed),
            attempts=action.attempts if loops else None,
            transitions=_transitions(transitions),
        )

    def _recover(self, index: int, back: str) -> str:
        """Add the node that undoes what the failure of a step leaves, and return its id."""
        failing = self._placed[index]
        action = self._use_case.actions[failing.step.action.recover]
        step = replace(failing.step, action=action)
        taken = sum(node.id.startswith(step.title) for node in self._recoveries)
        placed = _Placed(step, f"{step.title} {taken + 1}" if taken else step.title, failing.arm)
        ended = {**dict.fromkeys(action.done, back), FAILED: self._up(index)}
        self._recoveries.append(
            self._aside(placed, ended, self._up(index), tuple(self._known(index, placed)))
        )
        return placed.id

    def _give_up(self) -> Iterator[State | Behavior]:
        """Yield the nodes that empty the hands, one after another, whatever each one reports."""
        last = self._placed[-1]
        following = (*self._up_ids[1:], FAILED)
        for (action, arm), id_, after in zip(self._emptying, self._up_ids, following, strict=True):
            step = replace(last.step, action=action, end=None, clip=None)
            ended = dict.fromkeys((*action.done, FAILED), after)
            yield self._aside(_Placed(step, id_, arm), ended, after, ())

    def _aside(
        self, placed: _Placed, ended: dict[str, str], refused: str, known: tuple[Input, ...]
    ) -> State | Behavior:
        """Return a node beside the sequence; it leaves the error as the failure has written it."""
        action = placed.step.action
        if not action.is_behavior:
            ended[_COMMAND_ERROR] = refused
        return (Behavior if action.is_behavior else State)(
            id=placed.id,
            type=action.type,
            inputs=(*self._bound(placed), *known),
            params=self._params(placed),
            transitions=_transitions(ended),
        )

    def _up(self, index: int) -> str:
        """Return where giving up leads: to emptying the hands, if one may hold something."""
        held = any(placed.step.action.grasps for placed in self._placed[: index + 1])
        return self._up_ids[0] if held else FAILED

    def _earlier(self, index: int, action: str) -> str | None:
        """Return the node of the last step before that is this action."""
        found = [p.id for p in self._placed[:index] if p.step.action.name == action]
        return found[-1] if found else None

    def _known(self, index: int, placed: _Placed) -> Iterator[Input]:
        """Yield the inputs that take what steps before have revealed, and connect them."""
        for fact, key in placed.step.action.needs:
            if key:
                source, output = next(
                    (earlier.id, output)
                    for earlier in reversed(self._placed[:index])
                    for revealed, output in earlier.step.action.reveals
                    if revealed == fact
                )
                self._connections.append(Connection(source, output, placed.id, key))
                yield Input(key)

    def _bound(self, placed: _Placed) -> Iterator[Input]:
        """Yield the inputs that take values of the task, and connect them to the chart's."""
        for key, reference in placed.step.action.inputs:
            # An empty text stands for itself: whatever part the hand holds.
            name = _input_name(reference.removeprefix("$"), key, placed.step)
            value = self._value(placed, reference)
            kind = "string" if isinstance(value, str) else None
            self._inputs.setdefault(name, Input(name, kind, value))
            if name != key:
                self._connections.append(Connection(self._name, name, placed.id, key))
            yield Input(key, kind)

    def _params(self, placed: _Placed) -> tuple[Param, ...]:
        return tuple(
            Param(name, self._value(placed, value)) for name, value in placed.step.action.params
        )

    def _value(self, placed: _Placed, value: object) -> Literal:
        """Return a literal, or the value of the task that a reference names."""
        if not isinstance(value, str) or not value.startswith("$"):
            return value  # type: ignore[return-value]  # the schema allows literals only
        values = self._values.of(placed.step, placed.arm)
        if value[1:] not in values:
            raise UseCaseError(
                f"task {self._task.name}: {placed.step.action.name} refers to {value}, which it "
                f"does not have; there are {', '.join(f'${name}' for name in sorted(values))}"
            )
        return values[value[1:]]  # type: ignore[return-value]  # from JSON or YAML


def _place(steps: tuple[Step, ...], arms: tuple[str, ...]) -> Iterator[_Placed]:
    """Yield the steps with their own ids; the arm that receives at a handover does the rest."""
    arm = arms[0]
    for step, node in zip(steps, node_ids(steps), strict=True):
        if step.macro is Macro.HAND_OVER and step.action.grasps:
            arm = arms[-1]
        yield _Placed(step, node, arm)


def _input_name(reference: str, key: str, step: Step) -> str:
    """Return the name of the chart's input for a value of the task, of one end, or of one clip."""
    if not reference:
        return key
    if reference in ("end", "component", "terminal") and step.end is not None:
        return f"{step.end.letter}_{reference}"
    if reference == "clip" and step.clip is not None:
        return f"clip_{plain_name(step.clip.name)}"
    return key if reference == "task" else reference


def _transitions(targets: dict[str, str]) -> tuple[Transition, ...]:
    return tuple(Transition(event, target) for event, target in targets.items())


def _describe(task: Task, use_case: UseCase) -> str:
    stated = "".join(f", {name} {value}" for name, value in task.characteristics.items())
    ends = " to ".join(task.terminals[end] for end in End)
    return f"Task {task.name} of use case {use_case.name}: {ends}{stated}."
