"""The simulator's own services: faults and, for scoring only, the truth."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable
from typing import Protocol, TypeVar

import rospy
from remodel_msgs import srv
from remodel_msgs.msg import WireTruth as WireTruthMsg

from remodel_sim.core.faults import check_fault
from remodel_sim.physics.plant import SimulatedPlant
from remodel_sim.physics.truth import WireTruth, ground_truth
from remodel_work.errors import CellError

T = TypeVar("T")

# The longest request waits for a picture that a skill takes [s].
TIMEOUT_S = 60.0
SERVER_FAULTS = ("server_frozen", "server_killed")
# A node that is to be killed answers first; so long the answer has to get out [s].
ANSWER_S = 0.2


class Owner(Protocol):
    """Who owns the plant: what is asked is done in its thread, between two ticks."""

    def ask(self, question: Callable[[], T], timeout_s: float) -> T:
        """Evaluate a function; raises CellError when there is no answer in time, or its error."""

    def freeze(self, seconds: float) -> None:
        """Do nothing for so long."""


class Services:
    """Answers the simulator's services."""

    def __init__(self, plant: SimulatedPlant, owner: Owner) -> None:
        """Advertise all of them."""
        self._plant, self._owner = plant, owner
        for name, kind, answer in (
            ("ground_truth", srv.GetGroundTruth, self._ground_truth),
            ("inject_fault", srv.InjectFault, self._inject_fault),
        ):
            rospy.Service(f"cell/{name}", kind, answer)

    def _inject_fault(self, request: srv.InjectFaultRequest) -> srv.InjectFaultResponse:
        text = f"{request.kind} {request.target!r}"

        def disturb() -> None:
            values = tuple(request.values)
            if request.kind not in SERVER_FAULTS:
                self._plant.disturb(request.kind, request.target, values)
                return
            check_fault(request.kind, request.target, values)
            if request.kind == "server_frozen":
                self._owner.freeze(values[0])
            else:
                threading.Timer(ANSWER_S, os.kill, (os.getpid(), signal.SIGKILL)).start()

        return srv.InjectFaultResponse(*self._done(disturb, text))

    def _ground_truth(self, _: srv.GetGroundTruthRequest) -> srv.GetGroundTruthResponse:
        plant = self._plant
        truths = self._owner.ask(lambda: ground_truth(plant, list(plant.shapes())), TIMEOUT_S)
        return srv.GetGroundTruthResponse([truth_message(truth) for truth in truths])

    def _done(self, action: Callable[[], None], text: str) -> tuple[bool, str]:
        try:
            self._owner.ask(action, TIMEOUT_S)
        except CellError as error:
            return False, str(error)
        return True, text


def truth_message(truth: WireTruth) -> WireTruthMsg:
    """Return the truth about a wire as a message."""
    a, b = truth.a, truth.b
    return WireTruthMsg(
        wire_id=truth.wire_id,
        placed=truth.placed,
        a_at=a.at,
        b_at=b.at,
        a_depth=a.depth,
        b_depth=b.depth,
        a_fixed=a.fixed,
        b_fixed=b.fixed,
        duct_length=truth.duct_length,
        in_ducts=truth.in_ducts,
    )
