"""All scenarios, in the order in which they are played."""

from flexbe_testing.core.conformance.scenario import Scenario, scenarios_of
from flexbe_testing.ros.conformance.scenarios import (
    action,
    commands,
    containers,
    faults,
    locking,
    mirroring,
    presence,
    starting,
    supervision,
    switching,
    userdata,
)

# Without this one nothing else can be judged.
FIRST: Scenario = presence.runs_behaviors

ALL: tuple[Scenario, ...] = tuple(
    item
    for module in (
        presence,
        starting,
        supervision,
        commands,
        locking,
        mirroring,
        containers,
        userdata,
        faults,
        switching,
        action,
    )
    for item in scenarios_of(module)
)
