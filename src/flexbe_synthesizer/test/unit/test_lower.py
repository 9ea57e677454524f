from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from flexbe_synthesizer.core.chart.model import Autonomy
from flexbe_synthesizer.core.machine.lower import chart_steps
from flexbe_synthesizer.core.machine.machine import Condition, Container, Exit, Kind, walk


def children(machine):
    return dict(walk(machine.root))


def test_a_limit_of_attempts_puts_a_counter_before_the_state(machine):
    found = machine("place_connector.xml")
    counter = children(found)["/Locate_attempts"]
    assert found.root.children[0] is counter
    assert counter.exits == (Exit("counted", "Locate"), Exit("exhausted", "failed"))
    assert counter.content.arguments == (("attempts", 3),)
    assert counter.remapping == (("attempt", "locate_attempts"),)
    assert ("locate_attempts", 0) in found.root.userdata
    targets = {e.target for p, c in children(found).items() for e in c.exits if p.count("/") == 1}
    assert "Locate_attempts" in targets
    into = [p for p, c in children(found).items() if "Locate" in [e.target for e in c.exits]]
    assert into == ["/Locate_attempts"]


def test_a_timeout_is_given_to_a_state_that_keeps_time_itself(machine):
    locate = children(machine("place_connector.xml"))["/Locate"]
    assert locate.content.arguments == (("timeout_s", 5.0),)


def test_any_other_timeout_puts_a_timer_beside_the_state(machine):
    found = children(machine("place_connector.xml"))
    box = found["/Fix"]
    assert isinstance(box.content, Container)
    assert box.content.kind is Kind.CONCURRENCY
    assert box.content.conditions == (
        Condition("fixed", (("run", "fixed"),)),
        Condition("failed", (("run", "failed"),)),
        Condition("timed_out", (("timer", "done"),)),
    )
    assert found["/Fix/timer"].content.arguments == (("wait_time", 12.5),)
    assert found["/Fix/timer"].exits == (Exit("done", "timed_out", Autonomy.HIGH),)
    assert dict(box.remapping)["pose"] == "locate_pose"
    assert dict(found["/Fix/run"].remapping)["pose"] == "pose"


def test_routes_of_error_codes_are_outcomes_without_blanks(machine):
    # The FlexBE App drops blanks of a state's outcomes, and with them the transitions.
    chooser = children(machine("two_arms.xml"))["/Place/Insert_error"]
    outcomes = [e.outcome for e in chooser.exits]
    assert outcomes == [
        "failed_100_199",
        "failed_305",
        "failed_310_320",
        "failed_JAMMED",
        "failed_above_behavior",
        "other",
    ]
    (listed,) = (v for name, v in chooser.content.arguments if name == "outcomes")
    assert list(listed) == outcomes
    assert "'failed_100_199' if code in range(100, 200)" in str(chooser.content.arguments)
    # JAMMED is above the behavior too, and its own route comes first.
    assert "'failed_above_behavior' if code in (4, 5, 401)" in str(chooser.content.arguments)


def test_every_outcome_of_every_state_has_one_target_that_exists(machine):
    for chart in ("plain.xml", "place_connector.xml", "wire_task.xml"):
        root = machine(chart).root
        containers = [root, *(c.content for _p, c in walk(root))]
        for container in containers:
            if isinstance(container, Container):
                known = {c.label for c in container.children} | set(container.outcomes)
                for child in container.children:
                    assert {e.target for e in child.exits} <= known
                    assert len({e.outcome for e in child.exits}) == len(child.exits)


def test_the_interface_of_the_behavior_has_default_userdata(machine):
    root = machine("wire_task.xml").root
    defaults = dict(root.userdata)
    assert defaults == {"wire": "007", "tries": 0, "reason": None, "place_attempts": 0}
    assert root.input_keys == ("wire", "tries")
    assert root.output_keys == ("tries", "reason")


def test_an_input_of_a_behavior_that_has_a_default_may_stay_unfed(machine):
    clean = children(machine("wire_task.xml"))["/Clean"]
    assert clean.content.defaulted == ("thoroughness",)
    assert "thoroughness" not in dict(clean.remapping)


def test_what_an_engine_reports_is_translated_to_the_words_of_the_chart(golden):
    chart = parse_chart((golden / "charts" / "place_connector.xml").read_bytes())
    taken = [
        ("/Locate_attempts", "counted"),
        ("/Locate", "located"),
        ("/Insert", "inserted"),
        ("/Fix/run", "failed"),
        ("/Fix/timer", "done"),
        ("/Elsewhere", "done"),
        ("/Locate_attempts", "exhausted"),
    ]
    assert chart_steps(chart, taken) == (
        ("Locate", "located"),
        ("Insert", "inserted"),
        ("Fix", "failed"),
        ("Locate", "exhausted"),
    )
