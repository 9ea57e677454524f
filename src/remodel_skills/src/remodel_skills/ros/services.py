"""The cell's services: what feeds a wire, what loads a panel, and pictures for people."""

from __future__ import annotations

from collections.abc import Callable

import rospy
from remodel_msgs import srv
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from remodel_skills.ros.owner import Owner
from remodel_states.core.codes import Code
from remodel_states.core.wires.wire_materials import WireMaterials
from remodel_vision.ros.image_message import image
from remodel_work.errors import AbilityError, CellError, PanelError
from remodel_work.ros.panel_message import panel_from

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
            self._owner.cell.feed(request.wire_id, request.channel_id)

        text = f"{request.wire_id} lies in {request.channel_id}"
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
