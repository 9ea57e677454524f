#!/usr/bin/env python3
"""Write docs/reference/faults.md from the tables of remodel_msgs."""

from pathlib import Path

import yaml

ROOT = Path(__file__).parents[1]
CONFIG = ROOT / "src" / "remodel_msgs" / "config"
DOCUMENT = ROOT / "docs" / "reference" / "faults.md"

HEAD = """\
# Faults

What can go wrong with wires, cables and hoses, how it shows, and what is done about it.
Written by `tools/draw_faults.py` from [faults.yaml](../../src/remodel_msgs/config/faults.yaml)
and [error_codes.yaml](../../src/remodel_msgs/config/error_codes.yaml): change those.

Responses are tried in their order, as often as it says; the last one is for good.
A use case may answer otherwise.
"""


def drawn() -> str:
    """Return the document."""
    faults = yaml.safe_load((CONFIG / "faults.yaml").read_text())
    codes = {row["name"]: row for row in yaml.safe_load((CONFIG / "error_codes.yaml").read_text())}
    parts = [HEAD]
    for family in dict.fromkeys(fault["family"] for fault in faults):
        parts.append(f"\n## {family.capitalize()}\n")
        parts += [_fault(fault, codes) for fault in faults if fault["family"] == family]
    parts.append("\n## Error codes\n\n| code | name | meaning | what to do |\n|---|---|---|---|\n")
    parts += [
        f"| {row['code']} | {row['name']} | {row['meaning']} | {row['remedy']} |\n"
        for row in codes.values()
    ]
    return "".join(parts)


def _fault(fault: dict, codes: dict) -> str:
    shown = ", ".join(f"{codes[name]['code']} {name}" for name in fault["codes"])
    if "after" in fault:
        shown += f", {fault['after']['times']} times in a row"
    return (
        f"\n### {fault['fault']}\n\n{fault['symptoms']}\n\n"
        f"| shows as | severity | first level | responses |\n|---|---|---|---|\n"
        f"| {shown} | {fault['severity']} | {fault['first_level'].replace('_', ' ')} | "
        f"{', '.join(_response(response) for response in fault['responses'])} |\n"
    )


def _response(response: dict) -> str:
    text = response["do"].replace("_", " ")
    if "change" in response:
        text += " " + ", ".join(
            f"{name} {step['by']:+g} up to {step['at_most']:g}"
            for name, step in response["change"].items()
        )
    return text + (f" (x {response['times']})" if "times" in response else "")


if __name__ == "__main__":
    DOCUMENT.write_text(drawn())
