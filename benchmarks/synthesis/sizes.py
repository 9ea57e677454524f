#!/usr/bin/env python3
"""How long a chart takes from its bytes to its behavior's, by size, beside the physical floor.

sizes.py [SIZE ...] [--figures FILE]; the workspace must be sourced. The chart chains states of the
golden packages, with inputs, outputs, parameters, attempts and connections. The floor is what lxml
takes to parse the same bytes and to validate them against the schema. Times are CPU time, the best
of a few runs, taken in turn, so that a machine that is busy slows both.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections.abc import Callable
from pathlib import Path

from lxml import etree

sys.path.insert(0, str(Path(__file__).parents[1]))
from figures import add_figures_option, report_table

from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from flexbe_synthesizer.core.chart.chart_writer import write_chart
from flexbe_synthesizer.core.chart.model import (
    Chart,
    Connection,
    Input,
    Outcome,
    Output,
    Param,
    State,
    Transition,
)
from flexbe_synthesizer.core.chart.problem import errors_in
from flexbe_synthesizer.core.compile import Unit, check_units, compile_chart, manifest_of
from flexbe_synthesizer.core.export.certificate import certify, write_certificate
from flexbe_synthesizer.core.export.layout import lay_out
from flexbe_synthesizer.core.export.render_python import render_python
from flexbe_synthesizer.core.library.signature import Library
from flexbe_synthesizer.core.library.sources import write_manifest
from flexbe_synthesizer.edge.package_path import find_packages, read_library
from flexbe_synthesizer.synthesis import garbage_kept

PACKAGE = Path(__file__).parents[2] / "src" / "flexbe_synthesizer"
SIZES = (10, 100, 1000, 10000)


def chain(count: int) -> Chart:
    """Return a chart of states, each third of which tries a few times."""
    nodes, flows = [], []
    for index in range(count):
        on = f"S{index + 1}" if index < count - 1 else "finished"
        node_id = f"S{index}"
        if index % 3 == 0:
            exits = (Transition("located", on), Transition("failed", node_id))
            exits += (Transition("exhausted", "failed"),)
            nodes.append(State(node_id, "LocateComponentState", exits, attempts=3))
        else:
            exits = (Transition("inserted", on), Transition("failed", "failed"))
            force = (Param("force_limit_n", 20.0),)
            nodes.append(State(node_id, "InsertCableState", exits, params=force))
            flows.append(Connection(f"S{index - index % 3}", "pose", node_id, "pose"))
    return Chart(
        "Chain",
        "S0",
        (Outcome("finished"), Outcome("failed")),
        tuple(nodes),
        (Input("component_id", "string"), Input("cable_id", "string")),
        (Output("error_code", "int"),),
        tuple(flows),
    )


@garbage_kept()
def synthesize(text: bytes, library: Library) -> str:
    """Return the behavior, the manifest and the certificate that the text of a chart becomes."""
    unit = Unit(parse_chart(text, "chain.xml"), "bench")
    checked = check_units([unit], library)["chain.xml"]
    if errors_in(checked.problems):
        raise SystemExit("\n".join(map(str, checked.problems)))
    machine = compile_chart(checked, "bench")
    manifest = write_manifest(manifest_of(machine), machine.description)
    certificate = write_certificate(certify(checked, "bench"), "", "", [])
    return render_python(machine, lay_out(machine.root), {}) + manifest + certificate


def validate(text: bytes, schema: etree.XMLSchema) -> None:
    """Do no more than parse and validate the text of a chart."""
    schema.assertValid(etree.fromstring(text))


def time_ms(work: Callable[..., object], *arguments: object) -> float:
    """Return the CPU time of some work [ms]."""
    start = time.process_time()
    work(*arguments)
    return 1000 * (time.process_time() - start)


def main() -> None:
    """Print a row for each size."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("sizes", nargs="*", type=int, default=SIZES, metavar="SIZE")
    add_figures_option(parser)
    options = parser.parse_args()
    library = read_library(find_packages(str(PACKAGE / "test/golden/packages"))[0])[0]
    schema = etree.XMLSchema(etree.parse(PACKAGE / "schema/remodel_statechart.xsd"))
    rows = []
    for count in options.sizes:
        text = write_chart(chain(count)).encode()
        floor_ms = whole_ms = math.inf
        for _ in range(15 if count <= 1000 else 5):
            floor_ms = min(floor_ms, time_ms(validate, text, schema))
            whole_ms = min(whole_ms, time_ms(synthesize, text, library))
        row = {"states": f"{count:,}", "kB": f"{len(text) / 1000:,.0f}"}
        row |= {"floor [ms]": f"{floor_ms:.1f}", "whole [ms]": f"{whole_ms:.1f}"}
        rows.append({**row, "whole/floor": f"{whole_ms / floor_ms:.1f}"})
    report_table(rows, options.figures)


if __name__ == "__main__":
    main()
