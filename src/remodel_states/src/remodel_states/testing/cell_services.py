"""The services of a fake cell: feeder, panel, pictures, faults, and the truth."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import rospy
from remodel_msgs import srv
from remodel_msgs.msg import ErrorCode
from sensor_msgs.msg import Image
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from remodel_states.core.ability_error import AbilityError
from remodel_states.edge.exported_tables import read_faults
from remodel_states.serving import admitted
from remodel_states.testing.cell_ability import Course, RobotLock, Site, panel_from, truth_of
from remodel_states.testing.faults import Cure, InjectedFault, fault_from, when_fed, when_mended
from remodel_states.testing.operations import check_demands
from remodel_states.testing.world import Deed, Entry

CAMERAS = ("overhead", "wrist", "scene")

# [pixels] of a picture, and its one grey.
_WIDTH, _HEIGHT, _GREY = 8, 6, 128

# What the values of cell/inject_fault mean.
_VALUES = ("nth", "times", "at_least")


class CellServices:
    """Answers the services below the namespace `cell`."""

    def __init__(
        self,
        site: Site,
        read_faults: Callable[[], Sequence[dict[str, Any]]],
        *,
        truth: bool = True,
    ) -> None:
        """Advertise them all.

        Args:
            site: see Site.
            read_faults: returns those to be caused, whenever a panel is loaded: arguments of
                FaultTable.fault.
            truth: whether to offer the ground truth, too, which a real cell does not have.
        """
        self._site = site
        self._lock = RobotLock(site.lock_path)
        self._table = FaultTable()
        self._read_faults = read_faults
        for name, kind, answer in (
            ("load_panel", srv.LoadPanel, self._load_panel),
            ("feed_wire", srv.FeedWire, self._feed_wire),
            ("ground_truth", srv.GetGroundTruth, self._ground_truth),
            ("take_picture", srv.TakePicture, self._take_picture),
            ("inject_fault", srv.InjectFault, self._inject_fault),
            ("mend_faults", Trigger, self._mend_faults),
        ):
            if name == "ground_truth" and not truth:
                continue
            rospy.Service(f"cell/{name}", kind, answer)

    def _load_panel(self, request: srv.LoadPanelRequest) -> srv.LoadPanelResponse:
        def load() -> str:
            forces_n = dict(zip(request.abilities, request.force_limits, strict=True))
            check_demands(request.robots, forces_n)
            panel = panel_from(request.panel)
            faults = tuple(self._table.fault(**row) for row in self._read_faults())
            with self._site.file.change() as draft:
                before, cell = draft.world, self._site.cell
                draft.world = before.load(cell, panel, keep=request.keep)
                if draft.world is before:
                    return f"panel {panel.name!r} is there"
                draft.faults, draft.goals = faults, {}
                draft.entries.append(Entry(Deed.LOAD, self._site.cell, panel.name))
            return f"panel {panel.name!r} built"

        return srv.LoadPanelResponse(*self._done(load, request.owner))

    def _feed_wire(self, request: srv.FeedWireRequest) -> srv.FeedWireResponse:
        def feed() -> str:
            if not request.wire_id:
                return "no piece is being presented"
            self._feed(request.wire_id, request.channel_id, request.owner)
            return f"{request.wire_id} lies in {request.channel_id}"

        return srv.FeedWireResponse(*self._done(feed, request.owner))

    def _done(self, action: Callable[[], str], owner: int) -> tuple[bool, str, int]:
        """Do something for a supervisor while the robot is idle; return the fields of an answer."""
        try:
            self._site.admit(owner)
            if not self._lock.take():
                text = "the robot is doing a goal; wait for it or cancel it"
                return False, text, ErrorCode.BUSY
            try:
                return True, action(), ErrorCode.NONE
            finally:
                self._lock.free()
        except AbilityError as error:
            return False, str(error), error.code
        except (ValueError, TypeError) as error:
            return False, str(error), ErrorCode.INVALID_GOAL

    def _feed(self, wire: str, channel: str, owner: int) -> None:
        site = self._site
        number = sum(entry.deed is Deed.FEED for entry in site.file.ledger())
        course = Course.drawn(site.random("feed", number), site.duration_s)
        time.sleep(course.effect_s)
        with site.file.change() as draft:
            admitted(draft.owners, site.cell, owner)  # it may have lost the cell since
            is_new = wire not in draft.world.fed
            draft.world = draft.world.feed(site.cell, wire, channel)
            if is_new:
                draft.faults = when_fed(draft.faults, wire)
                draft.entries.append(Entry(Deed.FEED, site.cell, wire, terminal=channel))
        time.sleep(course.end_s - course.effect_s)

    def _ground_truth(self, _: srv.GetGroundTruthRequest) -> srv.GetGroundTruthResponse:
        world = self._site.file.read().world
        return srv.GetGroundTruthResponse([truth_of(world, wire) for wire in world.fed])

    def _take_picture(self, request: srv.TakePictureRequest) -> srv.TakePictureResponse:
        if request.camera not in CAMERAS:
            text = f"no camera {request.camera!r}; there are: {', '.join(CAMERAS)}"
            return srv.TakePictureResponse(success=False, message=text)
        image = Image(height=_HEIGHT, width=_WIDTH, encoding="rgb8", step=3 * _WIDTH)
        image.header.stamp, image.header.frame_id = rospy.Time.now(), request.camera
        image.data = bytes([_GREY]) * (image.step * image.height)
        return srv.TakePictureResponse(True, f"picture of {request.camera}", image)

    def _inject_fault(self, request: srv.InjectFaultRequest) -> srv.InjectFaultResponse:
        cure, _, wire = request.target.partition("/")
        if len(request.values) > len(_VALUES):
            text = f"values are {tuple(request.values)}; allowed, in this order: {_VALUES}"
            return srv.InjectFaultResponse(False, text)
        given: dict[str, Any] = dict(zip(_VALUES, request.values, strict=False))
        try:
            given.update({name: int(given[name]) for name in ("nth", "times") if name in given})
            fault = self._table.fault(request.kind, cure, wire=wire, **given)
        except (ValueError, OverflowError) as error:
            return srv.InjectFaultResponse(False, str(error))
        with self._site.file.change() as draft:
            draft.faults = (*draft.faults, fault)
        return srv.InjectFaultResponse(True, f"{fault.name} strikes {fault.ability}")

    def _mend_faults(self, _: TriggerRequest) -> TriggerResponse:
        with self._site.file.change() as draft:
            before = draft.faults
            draft.faults = when_mended(before)
            changed = [
                new.name for old, new in zip(before, draft.faults, strict=True) if old != new
            ]
        return TriggerResponse(True, f"mended: {', '.join(changed) or 'nothing had shown'}")


# The table of faults, as the fake cell reads it


class FaultTable:
    """What can go wrong, by name."""

    def __init__(self) -> None:
        """Read the tables of all packages."""
        tables = read_faults()
        self._rows, self._codes = tables.faults, tables.numbers

    def fault(self, name: str, cure: str = "", **given: object) -> InjectedFault:
        """Return a fault to be caused.

        Args:
            name: as in faults.yaml.
            cure: name of a Cure; empty: it passes by itself.
            given: other fields of the Fault, such as nth and wire.

        Raises:
            ValueError: if there is no such fault or cure, or a value is out of range.
        """
        if name not in self._rows:
            raise ValueError(f"no fault {name!r}; there are: {', '.join(self._rows)}")
        cures = [item.value for item in Cure]
        if cure and cure not in cures:
            raise ValueError(f"no cure {cure!r} of {name}; there are: {', '.join(cures)}")
        chosen = {"cure": Cure(cure)} if cure else {}
        return fault_from(self._rows[name], self._codes, **chosen, **given)
