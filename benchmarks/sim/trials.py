"""Trials of the abilities: each builds a cell from a seed, tries one thing, and returns the score.

Cameras and arm decide in the cell; here the truth is asked afterwards, for the score.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace

import numpy as np
import wire_task as task
from force_record import recorded

from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.truth import ground_truth, lies_in
from remodel_skills.abilities.extracting import DiscardGoal, discard_cable
from remodel_skills.abilities.inspection import CheckGoal, check_connection
from remodel_skills.cell import Cell
from remodel_skills.edge.parameter_files import read_parameters
from remodel_skills.force_control import ForceLoop
from remodel_skills.primitives.grasping import release
from remodel_skills.primitives.motions import rise
from remodel_states.core.codes import Code
from remodel_states.core.wires import DISTINCT_COLOURS
from remodel_work.errors import AbilityError
from remodel_work.geometry import Pose
from remodel_work.panel import Panel, PanelWire, WireEnd
from remodel_work.routes import world_from_clip

PARAMETERS = read_parameters().parameters

# An end that was picked is off the plate by so much [m].
LIFTED_M = 0.010
# How far beside the opening a socket pose lies that is wrong and not corrected [m].
OFFSET_M = 0.006
# Changes under which components are located. Blur and poses that are not level are no faults yet.
SHIFT_M = 0.010
TURN_RAD = math.radians(8.0)
LIGHT = (0.4, 1.6)
# A path over clips begins and ends so far from them, and runs so high [m].
BEYOND_CLIP_M = 0.020
PATH_Z_M = 0.050
# An end that is left before its opening or in it was pushed so far beside its axis [m], and into a
# blocked opening in this share of the trials.
LEFT_ASIDE_M = (0.0, 0.003, -0.006)
SHARE_BLOCKED = 0.5
# Force limits of pushes, as many as are no multiple of the panel's wires [N].
LIMITS_N = (4.0, 6.0, 8.0, 11.0, 14.0, 18.0, 25.0)


@dataclass(frozen=True)
class Outcome:
    """How one trial went.

    Attributes:
        good: whether it went as it should: success, or the refusal that was right.
        found: the code met with its message, or "NONE"; several, divided by "; ".
        figures: what else was measured, by name.
        pushes: of each push and pull under force control, as long as it keeps to one limit: the
            limit, the largest force at the wrist, not filtered, the largest that the ability knows
            of, and what is allowed [N]. The ability knows one of the whole motion: it stands with
            the motion's highest limit, 0 with others.
    """

    good: bool
    found: str
    figures: dict[str, float] = field(default_factory=dict)
    pushes: tuple[tuple[float, float, float, float], ...] = ()


@dataclass(frozen=True)
class Trial:
    """One thing to try, on one panel, from one seed."""

    name: str
    seed: int
    panel: Panel
    rate_hz: float = 240.0


def run(trial: Trial) -> Outcome:
    """Run a trial in a cell of its own.

    An error of an ability that the trial does not expect is a bad outcome; any other error is a
    mistake in the program, raised with the trial's name and seed.
    """
    with recorded() as records:
        outcome = _run(trial)
    highest: dict[ForceLoop, float] = {}
    for each in records:
        highest[each.loop] = max(each.limit, highest.get(each.loop, 0.0))
    pushes = tuple(
        (r.limit, r.peak, r.loop.peak if r.limit == highest[r.loop] else 0.0, r.allowed)
        for r in records
    )
    return replace(outcome, pushes=pushes)


def _run(trial: Trial) -> Outcome:
    cell = Cell(SimulatedPlant(trial.panel, seed=trial.seed, rate_hz=trial.rate_hz))
    wires = trial.panel.wires
    try:
        return TRIALS[trial.name](cell, wires[trial.seed % len(wires)])
    except AbilityError as error:
        return Outcome(False, _words(error))
    except Exception as error:
        error.add_note(f"trial {trial.name}, seed {trial.seed}")
        raise
    finally:
        cell.close()


def whole_wire(cell: Cell, wire: PanelWire) -> Outcome:
    """Place a wire as its chart does; good when both ends sit in closed terminals, by the truth."""
    history = task.History()
    wall, cpu = time.perf_counter(), time.process_time()
    try:
        task.place(cell, wire, history)
    except AbilityError as error:
        history.failures.append(error)
    figures = {"wall [s]": time.perf_counter() - wall, "cpu [s]": time.process_time() - cpu}
    (truth,) = ground_truth(cell.plant, [wire.id])
    for end, is_at in ((WireEnd.A, truth.a), (WireEnd.B, truth.b)):
        if end in history.attempts:
            figures[f"attempts at {end.value}"] = history.attempts[end]
            figures[f"placed {end.value}"] = float(is_at.seated and is_at.fixed)
    found = "; ".join(_words(error) for error in history.failures)
    return Outcome(truth.placed, found or Code.NONE.name, figures)


def pick(cell: Cell, wire: PanelWire) -> Outcome:
    """Pick end a; good when it is off the plate, by the truth."""
    cell.feed(wire.id, task.channel_of(cell, wire))
    found = _code_of(lambda: task.pick(cell, wire, WireEnd.A))
    assert cell.plant.live is not None, "it was fed"
    height = float(cell.plant.live.cable.tip(WireEnd.A)[0][2])
    return Outcome(height > LIFTED_M, found, {"height [m]": height})


def offset(cell: Cell, wire: PanelWire) -> Outcome:
    """Insert 6 mm beside the opening: the housing stops it."""
    side = OFFSET_M if cell.plant.seed % 2 else -OFFSET_M
    cell.feed(wire.id, task.channel_of(cell, wire))
    socket = task.locate_again(cell, *wire.goes_to(WireEnd.A))
    beside = Pose(socket.apply(np.array([0.0, side, 0.0])), socket.quaternion)
    return _refused(cell, wire, wire.goes_to(WireEnd.A), beside, Code.INSERTION_MISALIGNED)


def connector(cell: Cell, wire: PanelWire) -> Outcome:
    """Mate a connector with its header; good when it is latched there, by the truth."""
    found = _code_of(lambda: _connect(cell, wire))
    (truth,) = ground_truth(cell.plant, [wire.id])
    return Outcome(truth.a.seated and truth.a.fixed and found == Code.NONE.name, found)


def connector_offset(cell: Cell, wire: PanelWire) -> Outcome:
    """Mate a connector 6 mm beside its header."""
    found = _code_of(
        lambda: _connect(cell, wire, OFFSET_M if cell.plant.seed % 4 < 2 else -OFFSET_M)
    )
    return Outcome(_is(found, Code.INSERTION_MISALIGNED), found)


def connector_blocked(cell: Cell, wire: PanelWire) -> Outcome:
    """Mate a connector with a header that has a plug in one of its openings."""
    cell.plant.block_socket(*wire.goes_to(WireEnd.A))
    found = _code_of(lambda: _connect(cell, wire))
    return Outcome(_is(found, Code.INSERTION_JAMMED), found)


def _connect(cell: Cell, wire: PanelWire, aside: float = 0.0) -> None:
    """Feed a wire, locate the header of its end a, and push the connector there."""
    cell.feed(wire.id, task.channel_of(cell, wire))
    header = wire.goes_to(WireEnd.A)
    socket = task.locate_again(cell, *header)
    beside = Pose(socket.apply(np.array([0.0, aside, 0.0])), socket.quaternion)
    task.place_connector(cell, wire, header, beside)


def blocked(cell: Cell, wire: PanelWire) -> Outcome:
    """Insert into a terminal with a plug in its opening."""
    terminal = wire.goes_to(WireEnd.A)
    cell.plant.block_socket(*terminal)
    cell.feed(wire.id, task.channel_of(cell, wire))
    socket = task.locate_again(cell, *terminal)
    return _refused(cell, wire, terminal, socket, Code.INSERTION_JAMMED)


def push(cell: Cell, wire: PanelWire) -> Outcome:
    """Insert end a with each of the limits in turn; good when it is seated, by the truth."""
    found = _code_of(lambda: _push(cell, wire))
    (truth,) = ground_truth(cell.plant, [wire.id])
    return Outcome(truth.a.seated and found == Code.NONE.name, found)


def push_blocked(cell: Cell, wire: PanelWire) -> Outcome:
    """The same with a plug in the terminal."""
    cell.plant.block_socket(*wire.goes_to(WireEnd.A))
    found = _code_of(lambda: _push(cell, wire))
    return Outcome(_is(found, Code.INSERTION_JAMMED), found)


def _push(cell: Cell, wire: PanelWire) -> None:
    limit = LIMITS_N[cell.plant.seed % len(LIMITS_N)]
    terminal = wire.goes_to(WireEnd.A)
    cell.feed(wire.id, task.channel_of(cell, wire))
    socket = cell.plant.world_from_socket(*terminal)
    task.insert(cell, wire, WireEnd.A, terminal, socket, limit)


def other_component(cell: Cell, wire: PanelWire) -> Outcome:
    """Insert where end b's component is, under the name of end a's terminal."""
    cell.feed(wire.id, task.channel_of(cell, wire))
    socket = task.locate_again(cell, *wire.goes_to(WireEnd.B))
    return _refused(cell, wire, wire.goes_to(WireEnd.A), socket, Code.INVALID_GOAL)


def neighbour(cell: Cell, wire: PanelWire) -> Outcome:
    """Insert where the terminal beside end a's is, under the name of end a's."""
    component, own = wire.goes_to(WireEnd.A)
    others = [t.id for t in cell.context.panel.component(component).terminals if t.id != own]
    cell.feed(wire.id, task.channel_of(cell, wire))
    socket = task.locate_again(cell, component, others[cell.plant.seed % len(others)])
    return _refused(cell, wire, (component, own), socket, Code.INVALID_GOAL)


def occupied(cell: Cell, wire: PanelWire) -> Outcome:
    """Insert end b where end a sits."""
    terminal = wire.goes_to(WireEnd.A)
    cell.feed(wire.id, task.channel_of(cell, wire))
    task.connect(cell, wire, WireEnd.A, task.History())
    socket = task.locate_again(cell, *terminal)
    found = _code_of(lambda: task.insert(cell, wire, WireEnd.B, terminal, socket))
    return Outcome(_is(found, Code.TERMINAL_OCCUPIED), found)


def route(cell: Cell, wire: PanelWire) -> Outcome:
    """Lay a wire into the clips of the panel; good when it runs through all, by the truth."""
    panel = cell.context.panel
    cell.feed(wire.id, task.channel_of(cell, wire))
    task.connect(cell, wire, WireEnd.A, task.History())
    task.pick(cell, wire, WireEnd.B)
    wall, cpu = time.perf_counter(), time.process_time()
    found = _code_of(lambda: task.route(cell, wire, _over_clips(panel)))
    figures = {"wall [s]": time.perf_counter() - wall, "cpu [s]": time.process_time() - cpu}
    held = [lies_in(cell.plant, wire.id, clip) for clip in panel.clips]
    return Outcome(all(held) and found == Code.NONE.name, found, {"held": sum(held), **figures})


def _over_clips(panel: Panel) -> tuple[Pose, ...]:
    """Return a path from clip to clip, and a little beyond both ends, world frame."""
    clips = [world_from_clip(clip, panel) for clip in panel.clips]
    before, after = (Pose.level(x, 0.0, 0.0) for x in (-BEYOND_CLIP_M, BEYOND_CLIP_M))
    ways = [clips[0] @ before, *clips, clips[-1] @ after]
    return tuple(way @ Pose.level(0.0, 0.0, PATH_Z_M) for way in ways)


def discard(cell: Cell, wire: PanelWire) -> Outcome:
    """Place a wire and discard it; good when none of it is left on the panel, by the truth.

    In every second trial only end a was placed, and b lies loose.
    """
    with suppress(AbilityError):
        if cell.plant.seed % 2:
            task.place(cell, wire, task.History())
        else:
            cell.feed(wire.id, task.channel_of(cell, wire))
            task.connect(cell, wire, WireEnd.A, task.History())
    found = _code_of(lambda: task.do(cell, discard_cable, DiscardGoal(task.ROBOT, wire.id)))
    is_gone = not ground_truth(cell.plant, [wire.id])
    return Outcome(is_gone and found == Code.NONE.name, found)


def connections(cell: Cell, wire: PanelWire) -> Outcome:
    """Ask what sits in terminals while a wire is placed; good when no answer contradicts the truth.

    The wires get colours of their own, some the same. Asked is of empty terminals, of a fixed end,
    of its neighbours, of wires of other colours, and of an end that is left before or in its
    opening.
    """
    random = _random(cell)
    names = sorted(DISTINCT_COLOURS)
    some = random.choice(names, 2, replace=False)
    wires = tuple(replace(w, colour=str(random.choice(some))) for w in cell.plant.panel.wires)
    cell.load(replace(cell.plant.panel, wires=wires))
    wire = cell.context.panel.wire(wire.id)
    answers = [*_asked(cell, wire)]
    cell.feed(wire.id, task.channel_of(cell, wire))
    answers += _asked(cell, wire)
    with suppress(AbilityError):
        task.connect(cell, wire, WireEnd.A, task.History())
    answers += _asked(cell, wire)
    with suppress(AbilityError):
        _leave_before(cell, wire, random)
    answers += _asked(cell, wire)
    wrong = [words for words, seen, true in answers if seen is not None and seen is not true]
    figures = {
        "asked": float(len(answers)),
        "wrong": float(len(wrong)),
        "refused": float(sum(seen is None for _, seen, _ in answers)),
    }
    refused = [words for words, seen, _ in answers if seen is None]
    return Outcome(not wrong, "; ".join(wrong + refused) or Code.NONE.name, figures)


def _asked(cell: Cell, live: PanelWire) -> Iterator[tuple[str, bool | None, bool]]:
    """Yield what is said of the ends of all wires, and the truth; None: it was not seen.

    Each is asked for in its own terminal, those of the live wire in the neighbouring ones too.
    """
    panel = cell.context.panel
    for wire in panel.wires:
        truth = next(iter(ground_truth(cell.plant, [wire.id])), None)
        for end in WireEnd:
            component, own = wire.goes_to(end)
            beside = [t.id for t in panel.component(component).terminals if wire is live]
            is_at = truth and (truth.a if end is WireEnd.A else truth.b)
            for terminal in {own: None, **dict.fromkeys(beside)}:
                place = f"{component}/{terminal}"
                true = bool(is_at and is_at.at == place and is_at.fixed)
                words, seen = f"{wire.id} {end.value} in {place}", None
                try:
                    goal = CheckGoal(wire.id, end, component, terminal)
                    seen = task.do(cell, check_connection, goal).connected
                    words += f": said {seen}, true {true}"
                except AbilityError as error:
                    words += f": {_words(error)}"
                yield words, seen, true


def _leave_before(cell: Cell, wire: PanelWire, random: np.random.Generator) -> None:
    """Push end b at or into its opening, and release it there."""
    terminal = wire.goes_to(WireEnd.B)
    really = cell.plant.world_from_socket(*terminal)
    if random.random() < SHARE_BLOCKED:
        cell.plant.block_socket(*terminal)
    side = float(random.choice(LEFT_ASIDE_M))
    beside = Pose(really.apply(np.array([0.0, side, 0.0])), really.quaternion)
    with suppress(AbilityError):
        task.carry(cell, wire)
        task.insert(cell, wire, WireEnd.B, terminal, beside)
    if cell.context.belief.grip is not None:
        cell.run(release(cell.context, PARAMETERS.tool.open_m))
        cell.run(rise(cell.context))


def located(disturb: Callable[[Cell, str], None]) -> Callable[[Cell, PanelWire], Outcome]:
    """Return the trial that locates a terminal after something has been changed.

    Components take turns, not wires: every label is to be read.
    """

    def locate(cell: Cell, _: PanelWire) -> Outcome:
        components = cell.context.panel.components
        turn, which = divmod(cell.plant.seed, len(components))
        component = components[which].id
        terminals = components[which].terminals
        terminal = terminals[turn % len(terminals)].id
        disturb(cell, component)
        seen = task.locate(cell, component, terminal)
        really = cell.plant.world_from_socket(component, terminal)
        away = float(np.linalg.norm(seen.position - really.position))
        cosine = (np.trace(seen.rotation.T @ really.rotation) - 1) / 2
        turned = math.degrees(math.acos(float(np.clip(cosine, -1, 1))))
        return Outcome(True, Code.NONE.name, {"position [mm]": away * 1e3, "angle [deg]": turned})

    return locate


def _move(cell: Cell, component: str) -> None:
    values = _random(cell).uniform(-1, 1, 3) * (SHIFT_M, SHIFT_M, TURN_RAD)
    cell.plant.disturb("component_moved", component, values.tolist())


def _relight(cell: Cell, component: str) -> None:
    cell.plant.disturb("light_changed", "", [float(_random(cell).uniform(*LIGHT))])


def _random(cell: Cell) -> np.random.Generator:
    """Return what changes are drawn from: not the stream of the cell's own noise."""
    return np.random.default_rng([cell.plant.seed, 1])


TRIALS: dict[str, Callable[[Cell, PanelWire], Outcome]] = {
    "wire": whole_wire,
    "pick": pick,
    "offset": offset,
    "blocked": blocked,
    "push": push,
    "push_blocked": push_blocked,
    "connector": connector,
    "connector_offset": connector_offset,
    "connector_blocked": connector_blocked,
    "other_component": other_component,
    "neighbour": neighbour,
    "occupied": occupied,
    "route": route,
    "discard": discard,
    "connections": connections,
    "locate": located(lambda *_: None),
    "locate_moved": located(_move),
    "locate_light": located(_relight),
}


def _refused(
    cell: Cell, wire: PanelWire, terminal: tuple[str, str], socket: Pose, right: Code
) -> Outcome:
    """Insert end a; good when it is refused with the right code."""
    found = _code_of(lambda: task.insert(cell, wire, WireEnd.A, terminal, socket))
    return Outcome(_is(found, right), found)


def _code_of(work: Callable[[], object]) -> str:
    try:
        work()
    except AbilityError as error:
        return _words(error)
    return Code.NONE.name


def _is(found: str, code: Code) -> bool:
    return found.split(":")[0] == code.name


def _words(error: AbilityError) -> str:
    return f"{error.code.name}: {error}"
