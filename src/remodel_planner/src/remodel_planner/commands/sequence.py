"""`remodel sequence INSTANCE.dzn`: order the insertions of a cable tree."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path

from remodel_cable_tree.cable_tree_planner import Feasibility, contradiction, sequence
from remodel_cable_tree.problem import CableTree, cost_of, parse_cable_tree, violations
from remodel_planner.commands.options.common import refuses, seconds, seed, stop_on_signals
from remodel_production.errors import blamed
from remodel_tasks.edge.document_files import read_text
from remodel_tasks.errors import KernelError

_STATUS = {
    Feasibility.NONE: "unsatisfiable",
    Feasibility.FOUND: "found",
    Feasibility.UNDECIDED: "undecided",
}


@refuses("sequence")
def main(arguments: list[str] | None = None) -> int:
    """Search, check what is found, print it, and return the exit code."""
    parser = argparse.ArgumentParser(
        prog="remodel sequence",
        description="Find the order in which the ends of a harness's cables are inserted (Cable "
        "Tree Wiring). SIGINT or SIGTERM stops the search and prints the best order so far.",
        epilog="Exit code: 0 found, or proved that there is none; 1 refused (the file is "
        "malformed); 2 wrong usage; 3 undecided.",
    )
    parser.add_argument("instance", type=Path, help="MiniZinc data (.dzn)")
    parser.add_argument(
        "--time-limit", type=seconds, default=10.0, metavar="S", help="[s] of search (default 10)"
    )
    parser.add_argument("--seed", type=seed, default=1, help="decides among equals (default 1)")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    options = parser.parse_args(arguments)
    with blamed(options.instance):
        tree = parse_cable_tree(read_text(options.instance))
    with stop_on_signals() as stopped:
        found = sequence(tree, options.time_limit, options.seed, stopped)
        document = _document(options.instance.stem, tree, found.feasibility, found.order)
        if found.feasibility is Feasibility.NONE:
            conflict = contradiction(tree, options.time_limit, stopped)
            document |= {"contradiction": list(map(str, conflict))} if conflict else {}
    print(json.dumps(document) if options.json else _text(document))
    return 3 if found.feasibility is Feasibility.UNDECIDED else 0


def _document(
    name: str, tree: CableTree, feasibility: Feasibility, order: tuple[int, ...]
) -> dict[str, object]:
    document: dict[str, object] = {"instance": name, "status": _STATUS[feasibility]}
    if feasibility is not Feasibility.FOUND:
        return document
    violated = list(violations(tree, order))
    if violated:
        raise KernelError(f"the order found is refused, which is a defect: {violated[0]}")
    place = {end: i for i, end in enumerate(order, 1)}
    cost = asdict(cost_of(tree, order))
    return {
        **document,
        "cost": cost.pop("total"),
        **cost,
        "order": order,
        "pos": [place[end] for end in range(1, tree.ends + 1)],
    }


def _text(document: dict[str, object]) -> str:
    lists = ("order", "pos", "contradiction")
    lines = [f"{key}: {value}" for key, value in document.items() if key not in lists]
    if "contradiction" in document:
        lines.append("no order satisfies all of these constraints:")
        lines += [f"  {line}" for line in document["contradiction"]]  # type: ignore[attr-defined]
    if "order" in document:
        lines.append("order: " + " ".join(map(str, document["order"])))  # type: ignore[call-overload]
    return "\n".join(lines)
