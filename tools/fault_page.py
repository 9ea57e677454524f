"""The text of docs/reference/faults.md."""

from collections.abc import Mapping
from typing import Any

from remodel_states.core.fault_tables import FaultTables

HEAD = """\
# Faults

What can go wrong with wires, cables and hoses, how it shows, and what is done about it.
Written by `make generate`; change [faults.yaml](../../src/remodel_msgs/config/faults.yaml).

Responses are tried in the order given, each as often as stated; the last one is repeated. Before a
task continues with the same part, the supervisor inspects both ends of the wire. A use case may
respond otherwise ([recovery](../recovery.md)), except where an operator is asked at once.

| response | what happens |
|---|---|
| retry | the same again; the table never uses it, a use case or an operator may |
| retry with | the same with changed parameters, within their bounds and the terminal's |
| look again | the same, observed from another viewpoint each time |
| other method | the step that failed is done by the next method of the use case |
| new part | the old piece is discarded, a new one fed, and the task starts again |
| replan | the task comes later, in an order that is planned again |
| set aside | the task is skipped, the others continue |
| ask operator | the run waits for an answer; without an operator, `unattended` of the use case |
| stop | the run stops |
"""


def fault_page(tables: FaultTables) -> str:
    """Return the page."""
    faults = tables.faults.values()
    parts = [HEAD]
    for family in dict.fromkeys(fault["family"] for fault in faults):
        parts.append(f"\n## {family.capitalize()}\n")
        parts += [_fault(fault, tables) for fault in faults if fault["family"] == family]
    parts.append("\n## Error codes\n\n| code | name | meaning | what to do |\n|---|---|---|---|\n")
    parts += [
        f"| {code.number} | {code.name} | {code.meaning} | {code.remedy} |\n"
        for code in tables.codes.values()
    ]
    return "".join(parts)


def _fault(fault: Mapping[str, Any], tables: FaultTables) -> str:
    shown = ", ".join(f"{tables.codes[name].number} {name}" for name in fault["codes"])
    if "after" in fault:
        shown += f", {fault['after']['times']} times in a row"
    level = fault["first_level"].replace("_", " ")
    note = "; an unattended run stops" if fault.get("unattended") == "stop" else ""
    repeats = ""
    if fault.get("repeats") == "geometry":
        repeats = " What led to the same failure, figure for figure, is not done once more."
    head = (
        f"\n### {fault['fault']}\n\n{fault['symptoms']}\n\n"
        f"Reported as {shown}. Severity: {fault['severity']}. First level: {level}.{repeats}\n\n"
        "| response | because |\n|---|---|\n"
    )
    *others, last = fault["responses"]
    rows = [(_response(response), response["because"]) for response in others]
    rows.append((_response(last) + note, last["because"]))
    return head + "".join(f"| {do} | {because} |\n" for do, because in rows)


def _response(response: Mapping[str, Any]) -> str:
    text = response["do"].replace("_", " ")
    if "change" in response:
        text += " " + ", ".join(
            f"{name} {step['by']:+g} up to {step['at_most']:g}"
            for name, step in response["change"].items()
        )
    return text + (f" (x {response['times']})" if "times" in response else "")
