"""What the states of random charts offer, written down by hand and held to the real classes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class Kind:
    """A state class.

    Attributes:
        outcomes: empty if the parameter `outcomes` lists them.
        inputs, outputs: keys; None if the parameter `input_keys` or `output_keys` lists them.
        writes: the outputs that an outcome writes, if not all.
        keeps_time: it has a parameter `timeout_s`.
        is_scripted: a script says what it does.
    """

    outcomes: tuple[str, ...] = ()
    inputs: tuple[str, ...] | None = ()
    outputs: tuple[str, ...] | None = ()
    writes: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    keeps_time: bool = False
    is_scripted: bool = True

    def written(self, outcome: str, outputs: tuple[str, ...]) -> tuple[str, ...]:
        """Return which of its outputs an outcome writes."""
        return self.writes.get(outcome, outputs)


KINDS = {
    "StepState": Kind(("done", "failed")),
    "MakeState": Kind(("made", "failed"), (), ("item",), {"failed": ()}),
    "UseState": Kind(("used", "refused"), ("item",)),
    "TurnState": Kind(("turned", "not turned"), ("item",), ("result",)),
    "TallyState": Kind(("more", "enough"), ("count",), ("count",)),
    "AbilityState": Kind(
        ("done", "failed"),
        ("target",),
        ("error_code", "error_message", "pose"),
        {"done": ("pose",), "failed": ("error_code", "error_message")},
        keeps_time=True,
    ),
    "TryState": Kind(
        ("done", "failed", "timed_out"),
        (),
        ("error_code",),
        {"done": (), "failed": ("error_code",), "timed_out": ("error_code",)},
    ),
    "TiredState": Kind(("done", "exhausted"), (), ("item",)),
    "ChooseState": Kind(),
    "GatherState": Kind(("done",), None),
    "SpreadState": Kind(("done", "failed"), (), None),
    "UserDataState": Kind(("done",), (), ("data",), is_scripted=False),
    "CheckConditionState": Kind(("true", "false"), ("input_value",), is_scripted=False),
    "OperatorDecisionState": Kind(is_scripted=False),
    "WaitState": Kind(("done",), is_scripted=False),
}

# What packages/scripted_states/faults.yaml names, as far as the charts use it.
ERROR_NAMES = {"JAMMED": frozenset({2}), "above_behavior": frozenset({2, 3, 5})}
