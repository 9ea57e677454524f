"""Random charts do on the engine what the documentation says, and never lack data.

A seed that fails here is shown, shrunk, by `python3 -m random_charts --seed SEED`, and in full with
`--trace`; see "Random charts" in the package's README.
"""

import os
import subprocess
import sys
from collections import Counter
from importlib import import_module

import pytest
from lxml import etree
from random_charts.chart_xml import EXT, read_chart
from random_charts.engine_run import Synthesis, library
from random_charts.explore import explore, explore_all
from random_charts.generate import generate
from random_charts.judge import compare, judge, judge_seed
from random_charts.kinds import KINDS, Kind
from random_charts.shrink import shrink

from flexbe_synthesizer.core.library.signature import FromParameter

FEW, AT_ONCE, CHUNKS, RUNS = 10, 100, 20, 2
LANGUAGE = range(100)


def judged(first, count):
    """Return the verdicts of charts by seed; none may be wrong."""
    found = {seed: judge_seed(seed, RUNS) for seed in range(first, first + count)}
    assert [(seed, v.kind, v.details) for seed, v in found.items() if v.is_wrong] == []
    return found


def test_engine_and_reference_agree(fresh_seed):
    judged(fresh_seed, FEW)


@pytest.mark.slow
@pytest.mark.parametrize("chunk", range(CHUNKS))
def test_engine_and_reference_agree_on_many_charts(fresh_seed, chunk):
    judged(fresh_seed + chunk * AT_ONCE, AT_ONCE)


@pytest.mark.slow
def test_the_charts_are_worth_running():
    """Most are accepted, and all their runs are explored."""
    count = 2 * AT_ONCE
    found = judged(0, count)  # not fresh ones: of a hundred these shares are left to chance
    kinds = Counter(verdict.kind for verdict in found.values())
    assert kinds["agree"] > 0.7 * count, kinds
    assert kinds["refused"] > 0.05 * count, kinds
    assert kinds["refused without need"] < 0.08 * count, kinds
    assert sum(not verdict.is_explored for verdict in found.values()) < 0.03 * count


def test_a_seed_is_one_chart_in_every_process():
    command = "from random_charts.generate import generate\n"
    command += "print([generate(seed).files for seed in range(15)])"
    printed = {
        subprocess.run(
            [sys.executable, "-c", command],
            env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "PYTHONHASHSEED": number},
            check=True,
            capture_output=True,
        ).stdout
        for number in ("1", "2")
    }
    assert len(printed) == 1
    assert repr([generate(seed).files for seed in range(15)]).encode() in printed.pop()


def test_the_charts_hold_the_whole_language():
    elements, attributes, types = Counter(), Counter(), set()
    one_line = 0
    for seed in LANGUAGE:
        source = generate(seed)
        one_line += b"\n  " not in source.files[source.path]
        for content in source.files.values():
            for element in etree.fromstring(content).iter():
                elements[element.tag] += 1
                attributes.update(list(element.attrib))
                types.add(element.get("type", "").rpartition("/")[2].rpartition("__")[2])
    tags = ("priority", "container", "concurrency", "condition", "when")
    limits = ("attempts", "timeout_s", "on_error", "default", "autonomy")
    assert all(elements[f"{EXT}{tag}"] > 4 for tag in tags), elements
    assert all(attributes[f"{EXT}{name}"] > 4 for name in limits), attributes
    assert elements["behavior"] > 20
    assert one_line > 10
    assert types >= KINDS.keys()


def test_the_reference_knows_the_states_that_it_runs():
    for name, kind in KINDS.items():
        (found,) = library().find_states(name)
        assert found.name in vars(import_module(found.module))
        for stated, declared in (
            (kind.outcomes or None, found.outcomes),
            (kind.inputs, found.inputs),
            (kind.outputs, found.outputs),
        ):
            if isinstance(declared, FromParameter):
                assert stated is None, name
            else:
                assert stated == tuple(getattr(port, "name", port) for port in declared), name
        effects = {effect.outcome: effect.certain for effect in found.effects}
        for outcome in kind.outcomes:
            if kind.outputs:
                written = kind.written(outcome, kind.outputs)
                assert effects.get(outcome, set(kind.outputs)) == set(written), (name, outcome)


CHART = f"""<statemachine xmlns:ext="{EXT[1:-1]}" name="Held" initial="Make"><datamodel>
  <outcome name="ok"/><input name="spare"/><output name="found"/></datamodel>
  <state id="Make" type="MakeState" ext:attempts="2"><transition event="made" target="Use"/>
    <transition event="failed" target="Make"/><transition event="exhausted" target="ok"/></state>
  <state id="Use" type="UseState"><transition event="used" target="Set"/>
    <transition event="refused" target="Make"/></state>
  <state id="Set" type="UserDataState"><param name="data" value="7"/>
    <transition event="done" target="ok"/></state>
  <connection output_state_id="Make" output="item" input_state_id="Use" input="item"/>
  <connection output_state_id="Set" output="data" input_state_id="Held" input="found"/>
</statemachine>"""


@pytest.mark.parametrize(
    ("changed", "to", "respect"),
    [
        ('event="refused" target="Make"', 'event="refused" target="ok"', "path"),
        ('attempts="2"', 'attempts="3"', "path"),
        (
            'output_state_id="Make" output="item" input_state_id="Use"',
            'output_state_id="Held" output="spare" input_state_id="Use"',
            "values read",
        ),
        ('value="7"', 'value="8"', "outputs"),
    ],
)
def test_a_behavior_that_does_something_else_is_found(changed, to, respect, tmp_path):
    meant = read_chart({"main.xml": CHART.encode()}, "main.xml")
    assert changed in CHART
    other = CHART.replace(changed, to, 1)
    synthesis = Synthesis({"main.xml": other.encode()}, "main.xml", tmp_path)
    assert synthesis.errors == ()
    differences = [compare(synthesis, meant, str(number)) for number in range(30)]
    assert respect in {difference[0] for difference in differences if difference}


def test_a_hole_is_found_and_shrunk():
    """A chart that is accepted though its reference reads what no state has written."""
    source = generate(7)
    hole = CHART.replace('event="made" target="Use"', 'event="made" target="ok"')
    hole = hole.replace('event="exhausted" target="ok"', 'event="exhausted" target="Use"')
    files = {**source.files, "main.xml": hole.encode()}
    assert judge(files, "main.xml", 1).kind == "refused"
    faults = explore(read_chart(files, "main.xml"))
    assert [(fault.path, fault.key, fault.what) for fault in faults] == [
        ("/Use", "item", "not written")
    ]
    small = shrink(files, "main.xml", lambda found: bool(explore(read_chart(found, "main.xml"))))
    assert list(small) == ["main.xml"]
    assert len(small["main.xml"]) < len(hole)
    assert explore(read_chart(small, "main.xml"))


SIMPLE = {"Two": Kind(("a", "b")), "Read": Kind(("a",), ("v",)), "Write": Kind(("a",), (), ("v",))}
HEAD = f"""<statemachine xmlns:ext="{EXT[1:-1]}" name="A" initial="S">
  <datamodel><outcome name="o"/></datamodel>"""
BOTH = """<ext:concurrency id="S"><datamodel><outcome name="o"/></datamodel>
  <state id="L" type="Two"/><state id="R" type="Two"/>
  <ext:condition outcome="o"><ext:when state="L" event="a"/><ext:when state="R" event="a"/>
  </ext:condition>{}<transition event="o" target="o"/></ext:concurrency>"""
ANY = '<ext:condition outcome="o"><ext:when state="L" event="b"/></ext:condition>'
FLOW = '<connection output_state_id="W" output="v" input_state_id="T" input="v"/>'


def state(node_id, kind, more="", **targets):
    exits = "".join(f'<transition event="{e}" target="{t}"/>' for e, t in targets.items())
    return f'<state id="{node_id}" type="{kind}"{more}>{exits}</state>'


@pytest.mark.parametrize(
    ("body", "fault"),
    [
        (state("S", "Two", a="o"), ("/S", "b", "leads nowhere")),
        (state("S", "Two", a="o", b="x"), ("/x", "", "leads to no outcome")),
        (
            state("S", "Two", a="o", b="T") + state("T", "Write", a="T"),
            ("/T", "", "leads to no outcome"),
        ),
        (
            state("S", "Write", ' ext:attempts="2"', a="S", exhausted="S"),
            ("/S", "", "leads to no outcome"),
        ),
        (state("S", "Read", a="o"), ("/S", "v", "nothing feeds it")),
        (
            f"{state('S', 'Two', a='T', b='W')}{state('W', 'Write', a='T')}"
            f"{state('T', 'Read', a='o')}{FLOW}",
            ("/T", "v", "not written"),
        ),
        (BOTH.format(""), ("/S", "", "waits forever after L b, R b")),
        (BOTH.format(ANY), ("/S", "", "waits forever after L a, R b")),
    ],
)
def test_what_goes_wrong_in_some_run_is_found(body, fault):
    chart = read_chart({"a.xml": f"{HEAD}{body}</statemachine>".encode()}, "a.xml", SIMPLE)
    assert fault in explore_all(chart, 999)
