"""The text of docs/reference/faults.md."""

from collections.abc import Mapping
from typing import Any

from remodel_states.core.tables import FaultTables

HEAD = """\
# Faults

What can go wrong with wires, cables and hoses, how it shows, and what is done about it.
Written by `make generate`; change [faults.yaml](../../src/remodel_msgs/config/faults.yaml).

Responses are tried in the order given, each as often as stated; the last one is repeated. A use
case may respond otherwise ([recovery](../recovery.md)), except where an operator is asked at once.

| response | what happens |
|---|---|
| retry | the same again; the table never uses it, a use case or an operator may |
| retry with | the same with changed parameters, within their bounds and the terminal's |
| look again | the same, with all observations from another viewpoint: `view` n at the n-th time |
| other method | the step that failed is done by the next method of the use case |
| new part | the old piece is discarded, a new one fed, and the task starts again |
| other end | the same, and the end that came second comes first from now on |
| replan | the task is deferred, and the order of the remaining tasks is planned again |
| set aside | the task is skipped, the others continue |
| ask operator | the run waits for an answer; without an operator, `unattended` of the use case |
| stop | the run stops |

Before a task continues with the same part, the supervisor inspects both ends of the wire. A wire
that is set aside counts as done if both ends are found connected, unless it lies beside its duct:
then it is discarded. After a fault marked * what led to the same failure, figure for figure, is not
done once more.
"""

COLUMNS = """
| fault | how it shows; the codes that report it | severity | first level | responses, and why |
|---|---|---|---|---|
"""


def fault_page(tables: FaultTables) -> str:
    """Return the page."""
    faults = tables.faults.values()
    parts = [HEAD, COLUMNS]
    for family in dict.fromkeys(fault["family"] for fault in faults):
        parts.append(f"| **{family.capitalize()}** | | | | |\n")
        parts += [_row(fault, tables) for fault in faults if fault["family"] == family]
    parts.append("\n## Error codes\n\n| code | name | meaning | what to do |\n|---|---|---|---|\n")
    parts += [
        f"| {code.number} | {code.name} | {code.meaning} | {code.remedy} |\n"
        for code in tables.codes.values()
    ]
    return "".join(parts)


def _row(fault: Mapping[str, Any], tables: FaultTables) -> str:
    name = fault["fault"]
    shown = ", ".join(f"{tables.codes[code].number} {code}" for code in fault["codes"])
    if "after" in fault:
        shown += f", {fault['after']['times']} times in a row"
    star = "*" if fault.get("repeats") == "geometry" else ""
    responses = [
        f"{_response(response)}{_note(fault, response)}: {response['because']}"
        for response in fault["responses"]
    ]
    cells = (
        f'<a id="{name}"></a>{name}{star}',
        f"{fault['symptoms']} {shown}",
        fault["severity"],
        fault["first_level"].replace("_", " "),
        "<br>".join(responses),
    )
    return f"| {' | '.join(cells)} |\n"


def _note(fault: Mapping[str, Any], response: Mapping[str, Any]) -> str:
    is_last = response is fault["responses"][-1]
    stops = is_last and fault.get("unattended") == "stop"
    return " (an unattended run stops)" if stops else ""


def _response(response: Mapping[str, Any]) -> str:
    text = response["do"].replace("_", " ")
    if "change" in response:
        text += " " + ", ".join(
            f"{name} {step['by']:+g} up to {step['at_most']:g}"
            for name, step in response["change"].items()
        )
    text += f" (x {response['times']})" if "times" in response else ""
    return f"**{text}**"
