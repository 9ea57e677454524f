"""What a cell serves: an action for each ability; wires, panels and pictures by services.

Goals and requests wait for the thread that owns the plant.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import rospy
from genpy import Message
from remodel_msgs import srv
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from remodel_skills.abilities.ability import CellAbility, Goal
from remodel_skills.goal_checks import require, require_number
from remodel_skills.robot_context import RobotContext
from remodel_skills.ros.owner import Job, Owner
from remodel_states.ability_server import AbilityServer, Host
from remodel_states.core.codes import Code
from remodel_states.core.contract import ROBOT_FIELDS, owner_of
from remodel_states.core.tables import Ability
from remodel_states.core.wires import WireMaterials
from remodel_states.serving import RunningGoal
from remodel_vision.ros.image_message import image
from remodel_work.errors import AbilityError, CellError, PanelError
from remodel_work.ros.panel_message import panel_from

MAX_TIMEOUT_S = 3600.0


class CellAbilityServer(AbilityServer):
    """Takes goals for one ability; a robot does one goal at a time, over all abilities."""

    def __init__(
        self, ability: Ability, steps: CellAbility, owner: Owner, host: Host | None = None
    ) -> None:
        """Start to serve, over ROS unless a host is given."""
        self._steps = steps
        self._owner = owner
        super().__init__(ability, host=host)

    def schedule(self, take: Callable[[], None]) -> None:
        """Queue a new goal, to be accepted between two ticks."""
        self._owner.post(take)

    def prepare(self, goal: Message) -> tuple[list[RobotContext], Goal]:
        """Return the robots for a goal, and the goal."""
        self._owner.cell.admit(owner_of(goal.id))
        contexts = self._contexts(goal)
        return contexts, self._checked(goal, contexts)

    def start(self, running: RunningGoal, prepared: tuple[list[RobotContext], Goal]) -> None:
        """Queue a goal for the owner of the plant."""
        finish, keep = partial(self.finish, running), self._owner.cell.keep
        self._owner.jobs.append(Job(self._steps, running, *prepared, keep=keep, finish=finish))

    def elapsed(self) -> Callable[[], float]:
        """Return the plant's clock, from now on."""
        clock = self._owner.clock
        began_s = clock.now_s
        return lambda: clock.now_s - began_s

    def _contexts(self, message: Message) -> list[RobotContext]:
        """Return the robots that a goal names, or the one that is free for it when it names none.

        Raises UNKNOWN_NAME, or BUSY when one of them does another goal.
        """
        cell = self._owner.cell
        fields = [field for field in ROBOT_FIELDS if field in message.__slots__]
        if fields:
            contexts = [cell.context_of(getattr(message, field)) for field in fields]
        else:
            contexts = [self._free_context()]
        for context in contexts:
            job = self._owner.job_of(context.name)
            if job is not None:
                text = f"{context.name} is doing {job}; wait for it or cancel it"
                raise AbilityError(Code.BUSY, text)
            if context.busy:
                raise AbilityError(
                    Code.BUSY, f"{context.name} is making way for another robot; try again"
                )
        return contexts

    def _free_context(self) -> RobotContext:
        """Return a robot for an observation: an idle one, preferably with an empty hand."""

        def rank(context: RobotContext) -> tuple[bool, bool]:
            return context.busy, context.belief.grip is not None

        return min(self._owner.cell.contexts.values(), key=rank)

    def _checked(self, message: Message, contexts: Sequence[RobotContext]) -> Goal:
        """Return the goal of a message; raises AbilityError when it cannot be taken."""
        require(bool(message.id.strip()), "id is empty; it must name the goal")
        require_number("timeout", message.timeout, 0.1, MAX_TIMEOUT_S, unit="s")
        goal = self._steps.parse(message, self._owner.cell.plant.panel.world_from_panel)
        for context in contexts:
            goal.check(context.panel, context.belief, context.parameters)
        return goal


# The longest request is building a large panel.
TIMEOUT_S = 60.0


class Services:
    """Answers the cell's services, each in the owner's thread between two ticks."""

    def __init__(self, owner: Owner, materials: WireMaterials) -> None:
        """Advertise all of them; `materials` completes the wires of panels to come."""
        self._owner = owner
        self._materials = materials
        for name, kind, answer in (
            ("feed_wire", srv.FeedWire, self._feed_wire),
            ("load_panel", srv.LoadPanel, self._load_panel),
            ("reset", Trigger, self._reset),
            ("take_picture", srv.TakePicture, self._take_picture),
        ):
            rospy.Service(f"cell/{name}", kind, answer)

    def _feed_wire(self, request: srv.FeedWireRequest) -> srv.FeedWireResponse:
        def feed() -> None:
            self._owner.cell.admit(request.owner)
            self._require_idle()
            if request.wire_id:
                self._owner.cell.feed(request.wire_id, request.channel_id)

        text = f"{request.wire_id} lies in {request.channel_id}"
        if not request.wire_id:
            text = "no piece is being presented"
        return srv.FeedWireResponse(*self._coded(feed, text))

    def _load_panel(self, request: srv.LoadPanelRequest) -> srv.LoadPanelResponse:
        def load() -> None:
            self._owner.cell.admit(request.owner)
            self._require_idle()
            panel = panel_from(request.panel, self._materials)
            forces_n = dict(zip(request.abilities, request.force_limits, strict=False))
            self._owner.cell.load(
                panel, robots=request.robots, forces_n=forces_n, keep=request.keep
            )

        return srv.LoadPanelResponse(*self._coded(load, f"panel {request.panel.name!r} built"))

    def _reset(self, _: TriggerRequest) -> TriggerResponse:
        def reset() -> None:
            self._require_idle()
            self._owner.cell.load(self._owner.cell.plant.loaded)

        done, text, _ = self._coded(reset, "panel rebuilt, no wire on it")
        return TriggerResponse(done, text)

    def _take_picture(self, request: srv.TakePictureRequest) -> srv.TakePictureResponse:
        response, plant = srv.TakePictureResponse(), self._owner.cell.plant
        cameras = plant.design.camera_names
        if request.camera not in cameras:
            response.message = f"no camera {request.camera!r}; there are: {', '.join(cameras)}"
            return response

        def take() -> None:
            picture = plant.photograph(request.camera)
            response.image = image(picture.rgb, request.camera, self._owner.clock.now)

        done, text, _ = self._coded(take, f"picture of {request.camera}")
        response.success, response.message = done, text
        return response

    def _coded(self, action: Callable[[], None], text: str) -> tuple[bool, str, int]:
        """Return whether an action is done, a text, and the code of why it is not."""
        try:
            self._owner.ask(action, TIMEOUT_S)
        except AbilityError as error:
            return False, str(error), int(error.code)
        except PanelError as error:
            return False, str(error), int(Code.INVALID_GOAL)
        except CellError as error:
            return False, str(error), int(Code.INTERNAL)
        return True, text, int(Code.NONE)

    def _require_idle(self) -> None:
        if self._owner.jobs:
            job = self._owner.jobs[0]
            raise AbilityError(
                Code.BUSY, f"{job.robots[0]} is doing {job}; wait for it or cancel it"
            )
