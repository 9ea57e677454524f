"""A generated behavior is read back as the chart that gives it again, byte for byte."""

import re
from dataclasses import replace

import pytest
from app_judge import saved_by_app
from synthesizer_support.rendering import rendered

from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from flexbe_synthesizer.core.chart.chart_rewriter import rewrite_chart
from flexbe_synthesizer.core.chart.chart_writer import write_chart
from flexbe_synthesizer.core.chart.model import Container, walk_nodes
from flexbe_synthesizer.core.check.check import check_chart
from flexbe_synthesizer.core.compile import compile_chart, manifest_of
from flexbe_synthesizer.core.library.sources import write_manifest
from flexbe_synthesizer.core.machine.lift import lift
from flexbe_synthesizer.core.machine.machine_reader import InexpressibleError, read_machine

CHARTS = ("plain", "place_connector", "wire_task", "two_arms")


@pytest.fixture
def known(library, golden_behaviors):
    return library.with_behaviors(golden_behaviors.values())


def text_of(golden, name):
    return (golden / "behaviors" / f"{name}_sm.py").read_text()


@pytest.fixture
def read_back(known):
    """Return a function: text of a behavior -> its chart."""
    return lambda text: lift(read_machine(text, "a_sm.py", known), "a_sm.py")


@pytest.mark.parametrize("name", CHARTS)
def test_a_golden_behavior_becomes_a_chart_that_becomes_the_behavior(
    name, golden, known, read_back
):
    text = text_of(golden, name)
    again = parse_chart(write_chart(read_back(text)), "again.xml")
    checked = check_chart(again, known, {})
    assert checked.problems == ()
    machine = compile_chart(checked, "golden_behaviors")
    assert rendered(machine) == text


def test_author_and_tags_reach_code_and_manifest_and_the_author_comes_back(golden, known):
    source = (golden / "charts" / "plain.xml").read_text()
    text = rewrite_chart(source, replace(parse_chart(source), author="Ada L.", tags="demo <1>"))
    assert 'ext:author="Ada L." ext:tags="demo &lt;1&gt;"' in text
    chart = parse_chart(text, "plain.xml")
    assert (chart.author, chart.tags) == ("Ada L.", "demo <1>")
    assert parse_chart(write_chart(chart)) == chart
    assert parse_chart(rewrite_chart(text, replace(chart, tags=""))).tags == ""
    machine = compile_chart(check_chart(chart, known, {}), "golden_behaviors")
    code = rendered(machine)
    assert "@author: Ada L.\n" in code
    assert lift(read_machine(code, "a_sm.py", known), "a_sm.py").author == "Ada L."
    manifest = write_manifest(manifest_of(machine), "", machine.author, machine.tags)
    assert "<author>Ada L.</author>" in manifest
    assert "<tagstring>demo &lt;1&gt;</tagstring>" in manifest


@pytest.mark.parametrize("name", CHARTS)
def test_a_behavior_that_the_app_has_saved_gives_the_same_chart(
    name, golden, read_back, known_to_app
):
    text = text_of(golden, name)
    saved = saved_by_app(text, known_to_app)
    assert saved != text  # without the head that says where it comes from
    charts = [read_back(text), read_back(saved)]
    # The App names a package only if another one has a class of that name too.
    unqualified = [write_chart(chart).replace('type="cell_states/', 'type="') for chart in charts]
    assert unqualified[0] == unqualified[1]


def test_routes_in_the_spelling_of_earlier_versions_are_read(golden, read_back):
    text = text_of(golden, "two_arms")
    earlier = re.sub(r"failed_(\d+)_(\d+)", r"failed \1-\2", text).replace(
        "failed_305", "failed 305"
    )
    assert earlier.count("failed 100-199") > 3
    assert read_back(earlier) == read_back(text)


INSERT = "InsertCableState(force_limit_n=20)"


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        (
            "# [MANUAL_INIT]\n",
            "# [MANUAL_INIT]\n        self.x = 1\n",
            "custom code",
        ),
        (INSERT, "InsertCableState(force_limit_n=self.f)", "no literal"),
        (INSERT, "NoState()", "class NoState, whose arguments"),
        (INSERT, "InsertCableState(force_limit_n=lambda: 1)", "is Python source"),
        (
            "        # parameters of",
            "        self.add_parameter('a', 1) #",
            "a parameter of",
        ),
        ("        return _s", "        print()\n        return _s", "a custom statement"),
        ("'pose': 'locate_pose', 'force'", "'pose': 'nowhere', 'force'", "which no state writes"),
        ("class PlaceConnectorSM(Behavior)", "class PlaceConnectorSM(M)", "no class (Behavior)"),
        ("self.name = 'Place Connector'", "pass", "no self.name"),
        ("        return _state_machine", "        return None", "does not return a container"),
        ("            # x:1080 y:40", "            print()", "a custom call"),
        ("class", "clas", "not Python"),
        ("class", "x = " + "-" * 100_000 + "1\nclass", "nested too deeply"),
        ("class", "x = " + "+".join("1" * 3000) + "\nclass", "nested too deeply"),
        ("class", "x = 1\nclass", "a custom statement: x = 1"),
        ("        # parameters of", "        self.x = 1 #", "a custom statement: self.x = 1"),
        ("            # x:1080 y:40", "            x = 1", "a custom statement: x = 1"),
        (
            "    def create(self)",
            "    def other(self):\n        pass\n\n    def create(self)",
            "a custom method",
        ),
        ("add('Locate',", "add('Lo' 'cate' + '',", "the label of a state is no literal"),
        ("conditions=[", "conditions=['x', ", "a condition that is not"),
        ("_sm_fix_0,", "_state_machine,", "a container that it lies in itself"),
        ("        with _sm_fix_0:", "        with _sm_fix:", "_sm_fix_0 is a container without"),
        (INSERT, "self.use_behavior()", "which is not found"),
    ],
)
def test_what_a_chart_cannot_express_is_reported_with_its_place(
    old, new, reason, golden, read_back
):
    text = text_of(golden, "place_connector")
    assert old in text
    with pytest.raises(InexpressibleError) as caught:
        read_back(text.replace(old, new, 1))
    assert reason in str(caught.value)
    assert all(line.startswith("a_sm.py:") for line in caught.value.reasons)


@pytest.mark.parametrize(
    ("pattern", "new", "kept"),
    [
        (r"conditions=\[[^]]*\[[^=]*\n +\]\)", "conditions=[])", "Fix/timer"),
        (r"transitions=\{'done': 'timed_out'\}", "transitions={}", "Fix/timer"),
        (r", 'timed_out': 'Extract'", "", "Fix/timer"),
        (r", 'exhausted': 'failed'", "", "Locate_attempts"),
        (r"'attempt': 'locate_attempts'", "", "Locate_attempts"),
    ],
)
def test_what_lacks_a_part_of_a_timer_or_a_counter_stays_as_it_is(
    pattern, new, kept, golden, read_back
):
    text, changes = re.subn(pattern, new, text_of(golden, "place_connector"), count=1)
    assert changes == 1
    chart = read_back(text)
    bodies = {node.id: node.body for node in walk_nodes(chart) if isinstance(node, Container)}
    ids = {node.id for node in chart.nodes}
    ids |= {f"{name}/{node.id}" for name, body in bodies.items() for node in body.nodes}
    assert kept in ids


def test_transitions_may_be_given_by_position(golden, read_back):
    text = text_of(golden, "place_connector")
    chart = read_back(text)
    bare = re.sub(r"\b(transitions|autonomy|remapping)=(?=\{)", "", text)
    assert bare != text
    assert read_back(bare) == chart


def test_userdata_of_its_own_becomes_an_input_with_a_default(golden, read_back):
    text = text_of(golden, "place_connector")
    given = "        _state_machine.userdata.cable_id = None\n"
    text = text.replace(given, given + "        _state_machine.userdata.reel = 'left'\n")
    text = text.replace("'cable_id': 'cable_id', 'pose'", "'cable_id': 'reel', 'pose'", 1)
    chart = read_back(text)
    assert [(p.name, p.default) for p in chart.inputs][-1] == ("reel", "left")
    assert any(flow.output == "reel" and flow.input == "cable_id" for flow in chart.connections)
