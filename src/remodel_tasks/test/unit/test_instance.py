"""A problem that cannot be planned is refused before planning, with what is wrong and where."""

import pytest
from random_panel import random_panel

from remodel_production.errors import InstanceError
from remodel_tasks.core.problem.defects import require_sound
from remodel_tasks.core.problem.instance import plan_from, problem_from


def refusal(change, arms=1, wires=8):
    data = random_panel(wires, 1, arms)
    change(data)
    with pytest.raises(InstanceError) as caught:
        require_sound(problem_from(data))
    return str(caught.value)


def test_sound_panels_are_accepted():
    for arms in (1, 2):
        require_sound(problem_from(random_panel(40, 2, arms)))


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ("format", "planbench-2", "format: expected one of planbench-1, found 'planbench-2'"),
        ("wires", {}, "wires: expected a list, found {}"),
        ("wires.2", 7, "wires[2]: expected an object, found 7"),
        ("wires.2.slot", [1], "wires[2].slot: expected two integers"),
        ("wires.2.slot", [1, True], "wires[2].slot: expected two integers"),
        ("wires.2.route", -1, "wires[2].route: expected an integer from 0 to 100000, found -1"),
        ("wires.2.route", 1e3, "wires[2].route: expected an integer"),
        ("wires.2.heavy", 1, "wires[2].heavy: expected true or false, found 1"),
        ("wires.2.segments", ["a", 1], "wires[2].segments: expected a list of texts"),
        ("speed", 0, "speed: expected an integer from 1 to 100000, found 0"),
        ("precedence", [{"type": "over"}], "precedence[0].type: expected one of under, pin"),
        ("init.arms", {}, "init.arms.A: expected a value, found nothing"),
        ("init.history", [["w1"]], "init.history: expected a list of [wire, arm]"),
        ("init.wires", {"w1": {"stage": "lost"}}, "init.wires.w1.stage: expected one of stored"),
        ("arms.0.id", 3, "arms[0].id: expected text, found 3"),
    ],
)
def test_malformed_fields_are_named(path, value, message):
    def change(data):
        *parents, last = (int(key) if key.isdigit() else key for key in path.split("."))
        for key in parents:
            data = data[key]
        data[last] = value

    assert message in refusal(change)


def test_the_document_must_be_an_object():
    with pytest.raises(InstanceError, match="the document: expected an object, found 3"):
        problem_from(3)


def test_more_than_two_arms_are_refused():
    def change(data):
        data["arms"] = [{**data["arms"][0], "id": name} for name in "ABC"]
        data["init"]["arms"] = {name: data["init"]["arms"]["A"] for name in "ABC"}

    assert "arms: 3 found; this planner plans for one or two" in refusal(change)


def test_missing_component_is_named():
    def change(data):
        data["components"] = data["components"][1:]

    assert "component c" in refusal(change)
    assert "is missing" in refusal(change)


def under(before, after):
    return {"type": "under", "before": before, "after": after}


def pin_within(wire, first, second):
    return {
        **{"type": "pin", "before": wire, "before_end": first},
        **{"after": wire, "after_end": second},
    }


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d["wires"].append(d["wires"][0]), "wire w0: defined 2 times"),
        (lambda d: d["wires"][3].update(a="nowhere"), "wire w3, end a: no terminal nowhere"),
        (lambda d: d["wires"][3].update(tool="G9"), "wire w3: no tool G9; there are G1, G2, G3"),
        (
            lambda d: d["soft_before"].append({"before": "w0", "after": "w99", "weight": 3}),
            "soft constraint w0 before w99: no wire w99",
        ),
        (
            lambda d: d["wires"][1].update(b=d["wires"][0]["a"]),
            "used by w0.a, w1.b; a terminal takes one wire end",
        ),
        (
            lambda d: d.update(
                precedence=[under("w0", "w1"), under("w1", "w2"), under("w2", "w0")]
            ),
            "cyclic precedence: w0 before w1 before w2 before w0",
        ),
        (
            lambda d: d.update(precedence=[pin_within("w0", "a", "b"), pin_within("w0", "b", "a")]),
            "cyclic precedence: the pins of wire w0",
        ),
    ],
)
def test_what_contradicts_itself_or_names_what_is_not_there_is_refused(change, message):
    assert message in refusal(change)


def test_unreachable_terminal_is_named():
    def change(data):
        name = data["wires"][0]["a"]
        next(t for t in data["terminals"] if t["id"] == name)["x"] = 5000

    text = refusal(change)
    assert "wire w0 is unreachable: terminal" in text
    assert "(x = 5000 mm) out of every arm's reach; reach in x [mm]: A -1000..1600" in text


def test_wire_that_no_arm_reaches_as_a_whole_is_refused():
    def change(data):
        for wire in data["wires"]:
            wire["handover"] = None

    assert "no arm reaches its slot and both terminals" in refusal(change, arms=2, wires=60)


@pytest.mark.parametrize(
    ("state", "message"),
    [
        ({"stage": "held"}, "wire w0 is held, so one arm must hold it; 0 do"),
        ({"stage": "stored", "jam": "a"}, "wire w0 is stored: no end can be jammed then"),
    ],
)
def test_impossible_states_of_wires_are_refused(state, message):
    assert message in refusal(lambda d: d["init"]["wires"].update(w0=state))


def test_first_end_of_a_wire_in_work_must_be_given():
    def change(data):
        data["init"]["arms"]["A"]["holding"] = "w0"
        data["init"]["wires"]["w0"] = {"stage": "in1"}

    assert "wire w0 is first in: its first end must be given" in refusal(change)


def test_arms_that_would_wait_for_each_other_are_refused():
    def change(data):
        data["init"]["arms"]["A"]["holding"] = "w0"
        data["init"]["wires"]["w0"] = {"stage": "held"}
        data["precedence"] = [under("w1", "w0")]

    assert "the arms would wait for each other with the wires that they hold (A w0)" in refusal(
        change
    )


def test_malformed_plans_are_refused():
    action = {"a": "pick", "arm": "A", "wire": "w0", "t": 3}
    for change, message in (
        ({"a": "jump"}, r"actions\[0\].a: expected one of tool, pick"),
        ({"t": None}, r"actions\[0\].t: expected an integer"),
        ({"a": "route", "to": "c"}, r"actions\[0\].to: expected one of a, b, h"),
    ):
        with pytest.raises(InstanceError, match=message):
            plan_from({"instance": "x", "actions": [{**action, **change}]})
