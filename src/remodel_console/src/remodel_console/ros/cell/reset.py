"""Have a simulated cell rebuild its panel."""

from __future__ import annotations

from std_srvs.srv import Trigger, TriggerRequest

from remodel_console.errors import CommandError
from remodel_console.ros import topics
from remodel_console.ros.call_service import call_service

RESET = f"{topics.CELL}/reset"  # a service that only simulated cells have
_LIMIT_S = 60.0  # wall time; a large panel takes some


def reset_cell() -> str:
    """Have the cell rebuild its panel without wires, and return its answer.

    Raises:
        CommandError: if it does not answer, or refuses.
    """
    answer = call_service(RESET, Trigger, TriggerRequest(), _LIMIT_S)
    if not answer.success:
        raise CommandError(f"the cell is not reset: {answer.message}")
    return str(answer.message)
