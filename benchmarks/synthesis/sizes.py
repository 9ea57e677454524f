#!/usr/bin/env python3
"""How long a chart takes from its bytes to its behavior's, by size, beside the physical floor.

The chart chains states of the golden packages, with inputs, outputs, parameters, attempts and
connections. The floor is what lxml takes to parse the same bytes and to validate them against the
schema. Times are CPU time, the best of a few runs, each step taken in turn, so that a machine that
is busy with something else slows all of them; memory is what the resident set of a fresh process
grows.

Usage: sizes.py [--figures FILE] [SIZE ...]
"""

import argparse
import json
import math
import multiprocessing
import re
import time
from collections.abc import Callable, Mapping
from pathlib import Path

from lxml import etree

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
from flexbe_synthesizer.core.check.check import CheckedChart
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
TIMES_FLOOR, BYTES_PER_BYTE = 8, 100  # what is aimed for: of the floor's time, of the chart's size


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


def best(works: Mapping[str, Callable[[], object]], runs: int) -> dict[str, float]:
    """Return the shortest CPU time of a few runs of each work, taken in turn [s]."""
    times = dict.fromkeys(works, math.inf)
    for _ in range(runs):
        for name, work in works.items():
            start = time.process_time()
            work()
            times[name] = min(times[name], time.process_time() - start)
    return times


@garbage_kept()
def synthesize(text: bytes, library: Library) -> str:
    """Return the behavior and the manifest that the text of a chart becomes."""
    unit = Unit(parse_chart(text, "chain.xml"), "bench")
    checked = check_units([unit], library)["chain.xml"]
    return generate(checked) + certificate(checked)


def generate(checked: CheckedChart) -> str:
    """Return the texts of the behavior and of its manifest."""
    machine = compile_chart(checked, "bench")
    manifest = write_manifest(manifest_of(machine), machine.description)
    source = render_python(machine, lay_out(machine.root), {})
    return source + manifest


def certificate(checked: CheckedChart) -> str:
    """Return the text of the certificate, which each synthesis writes beside the behavior."""
    return write_certificate(certify(checked, "bench"), "", "", [])


@garbage_kept()
def measure(count: int, library: Library, schema: etree.XMLSchema) -> dict[str, float]:
    """Return the times of each step [s] for a chart of some states."""
    text = write_chart(chain(count)).encode()
    runs = 15 if count <= 1000 else 5
    chart = parse_chart(text, "chain.xml")
    checked = check_units([Unit(chart, "bench")], library)["chain.xml"]
    if errors_in(checked.problems):
        raise SystemExit("\n".join(map(str, checked.problems)))

    works: dict[str, Callable[[], object]] = {
        "floor": lambda: schema.assertValid(etree.fromstring(text)),
        "parse": lambda: parse_chart(text, "chain.xml"),
        "check": lambda: check_units([Unit(chart, "bench")], library),
        "generate": lambda: generate(checked),
        "certificate": lambda: certificate(checked),
        "whole": lambda: synthesize(text, library),
    }
    return {"bytes": len(text), **best(works, runs)}


def grown_bytes(count: int) -> float:
    """Return how much a fresh process grows when it synthesizes a chart [bytes per byte]."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(_grow, (count,))


def _grow(count: int) -> float:
    library = _library()
    text = write_chart(chain(count)).encode()
    synthesize(write_chart(chain(10)).encode(), library)  # what every process needs once
    Path("/proc/self/clear_refs").write_text("5")  # the peak counts from here
    before = _peak_kib()
    synthesize(text, library)
    return (_peak_kib() - before) * 1024 / len(text)


def _peak_kib() -> int:
    status = Path("/proc/self/status").read_text()
    return int(re.search(r"VmHWM:\s+(\d+)", status)[1])


def _library() -> Library:
    packages, _warnings = find_packages(str(PACKAGE / "test" / "golden" / "packages"))
    return read_library(packages)[0]


def main() -> None:
    """Print a row for each size, and write those of the docs' table, if there is a file."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("sizes", nargs="*", type=int, default=SIZES, metavar="SIZE")
    parser.add_argument("--figures", type=Path, metavar="FILE", help="docs/figures/synthesis.jsonl")
    options = parser.parse_args()
    rows = []
    library = _library()
    schema = etree.XMLSchema(etree.parse(PACKAGE / "schema" / "remodel_statechart.xsd"))
    steps = ("floor", "parse", "check", "generate", "certificate", "whole")
    heads = (*(f"{step} [ms]" for step in steps), "whole/floor", "memory [B/B]")
    print(f"{'states':>7} {'kB':>6} " + " ".join(f"{head:>13}" for head in heads))  # noqa: T201
    for count in options.sizes:
        found = measure(count, library, schema)
        ratio = found["whole"] / found["floor"]
        cells = [f"{found[step] * 1000:.1f}" for step in steps]
        cells += [f"{ratio:.1f}", f"{grown_bytes(count):.0f}"]
        row = " ".join(f"{cell:>13}" for cell in cells)
        print(f"{count:>7} {found['bytes'] / 1000:>6.0f} {row}")  # noqa: T201
        size = {"states": f"{count:,}", "kB": f"{found['bytes'] / 1000:,.0f}"}
        rows.append({**size, **dict(zip(heads, cells, strict=True))})
    if options.figures:
        options.figures.write_text("".join(f"{json.dumps(row)}\n" for row in rows))
    print(f"aimed for: whole/floor {TIMES_FLOOR}, memory {BYTES_PER_BYTE}")  # noqa: T201


if __name__ == "__main__":
    main()
