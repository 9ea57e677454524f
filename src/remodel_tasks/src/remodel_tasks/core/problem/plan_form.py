"""Write and read plans in the benchmark's JSON form (docs/planning.md)."""

from __future__ import annotations

from remodel_tasks.core.problem.fields import GREATEST_TIME, Fields
from remodel_tasks.core.problem.problem import Action, ActionKind, End, Plan

_TARGET_KEYS = {
    ActionKind.CHANGE_TOOL: "tool",
    ActionKind.LOCATE: "term",
    ActionKind.HAND_OVER: "to_arm",
}
_WITH_WIRE = frozenset(ActionKind) - {ActionKind.CHANGE_TOOL, ActionKind.LOCATE}
_WITH_END = frozenset({ActionKind.INSERT, ActionKind.EXTRACT})
_HANDOVER_POINT = "h"


def plan_data(plan: Plan) -> dict[str, object]:
    """Return the plan as a JSON document."""
    return {"instance": plan.problem, "actions": [_action_data(action) for action in plan.actions]}


def plan_from(data: object) -> Plan:
    """Build the plan that a parsed document describes.

    Raises:
        InstanceError: naming the first field that is missing or malformed.
    """
    fields = Fields(data, "")
    actions = sorted(map(_action, fields.objects("actions")), key=lambda a: a.start_ticks)
    return Plan(fields.text("instance"), tuple(actions))


def _action_data(action: Action) -> dict[str, object]:
    kind = action.kind
    data: dict[str, object] = {"a": kind.value, "arm": action.arm}
    if kind in _WITH_WIRE:
        data["wire"] = action.wire
    if kind in _TARGET_KEYS:
        data[_TARGET_KEYS[kind]] = action.target
    if kind in _WITH_END and action.end is not None:
        data["end"] = action.end.letter
    if kind is ActionKind.ROUTE:
        data["to"] = _HANDOVER_POINT if action.end is None else action.end.letter
    data["t"] = action.start_ticks
    return data


def _action(fields: Fields) -> Action:
    kind = ActionKind(fields.choice("a", tuple(kind.value for kind in ActionKind)))
    end = None
    if kind in _WITH_END:
        end = End("ab".index(fields.choice("end", ("a", "b"))))
    elif kind is ActionKind.ROUTE:
        to = fields.choice("to", ("a", "b", _HANDOVER_POINT))
        end = None if to == _HANDOVER_POINT else End("ab".index(to))
    return Action(
        kind,
        fields.text("arm"),
        fields.number("t", greatest=GREATEST_TIME),
        fields.text("wire") if kind in _WITH_WIRE else None,
        end=end,
        target=fields.text(_TARGET_KEYS[kind]) if kind in _TARGET_KEYS else None,
    )
