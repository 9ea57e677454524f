"""Each small mistake in a good chart is refused in its place, or is none.

Seeded mutants of the golden charts: one thing dropped, redirected, renamed, doubled or swapped. The
checker must refuse a mutant with an error in a line that has to do with the mutation; a mutant that
it lets pass must be harmless in every run, by the reference that explores them all.
"""

import random
import re
from collections import Counter
from dataclasses import dataclass

import pytest
from random_charts import chart_xml
from random_charts.explore import explore_all
from random_charts.kinds import Kind

from flexbe_synthesizer.core.chart.chart_reader import parse_chart, read_chart
from flexbe_synthesizer.core.chart.problem import ProblemKind, errors_in
from flexbe_synthesizer.core.check.check import check_chart
from flexbe_synthesizer.core.library.signature import FromParameter

CHARTS = ("plain.xml", "place_connector.xml", "wire_task.xml", "two_arms.xml")
FEW, MANY = 30, 600
MOST_STEPS = 200_000
ELEMENT = re.compile(r"\s*<((?:ext:)?\w+)((?:\s+[\w:]+=(?:\"[^\"]*\"|'[^']*'))*)\s*(/?)>")
LEFT_FAILED = '<ext:when state="Left" event="failed"/>'
RIGHT_FAILED = '<ext:when state="Right" event="failed"/>'
ATTRIBUTE = re.compile(r"([\w:]+)=(\"[^\"]*\"|'[^']*')")


@dataclass(frozen=True)
class Mutant:
    name: str
    what: str
    text: str
    lines: frozenset[int]  # where an error has to do with the mutation
    key: str  # the input or output that was changed: the state that needs it may be far away


def elements(lines):
    """Yield index, tag, attributes and whether the element stands in one line."""
    for index, line in enumerate(lines):
        found = ELEMENT.match(line)
        if found:
            values = {k: v[1:-1] for k, v in ATTRIBUTE.findall(found[2])}
            yield index, found[1], values, bool(found[3])


def around(lines, index):
    """Return the indices of the elements that a line stands in, innermost first."""
    depth = len(lines[index]) - len(lines[index].lstrip())
    for above in range(index, -1, -1):
        indent = len(lines[above]) - len(lines[above].lstrip())
        if indent < depth and lines[above].lstrip().startswith("<"):
            depth = indent
            yield above


def related(before, after, index):
    """Return the lines of a mutant that have to do with the line changed in the chart before.

    They are the element that holds the line, those around it, the elements that name what the line
    names or named, and those around them.
    """
    first, *others = (*around(before, index), 0)
    named = names_in(before[index]) | names_in(before[first])
    named |= names_in(after[index]) if index < len(after) else set()
    values = {i for i, line in enumerate(after) if named & names_in(line)}
    inside = {o for i in values for o in list(around(after, i))[:1]}
    whole = set(range(first, end_of(after, first))) if first else set()
    whole |= set(range(index, end_of(after, index))) if index < len(after) else set()
    return frozenset(i + 1 for i in whole | set(others) | values | inside)


def names_in(line):
    return {value[1:-1] for _, value in ATTRIBUTE.findall(line)}


def set_value(line, attribute, value):
    return re.sub(rf'(\s{attribute}=)("[^"]*"|\'[^\']*\')', lambda m: f'{m[1]}"{value}"', line)


def drop_attribute(line, attribute):
    return re.sub(rf'\s{attribute}=("[^"]*"|\'[^\']*\')', "", line)


def end_of(lines, index):
    """Return the index after the element that starts in a line."""
    indent = re.match(r"\s*", lines[index])[0]
    found = ELEMENT.match(lines[index])
    if found is None or found[3]:
        return index + 1
    tag = found[1]
    for end in range(index, len(lines)):
        if lines[end].startswith(f"{indent}</{tag}>"):
            return end + 1
    return index + 1


def mutations(lines, pick):
    """Yield (what, index of the changed line, lines after) of every kind, at a random place."""
    found = list(elements(lines))

    def some(tags, test=lambda values: True):
        fitting = [(i, v) for i, tag, v, _ in found if tag in tags and test(v)]
        return pick.choice(fitting) if fitting else None

    def changed(what, index, line):
        return what, index, [*lines[:index], line, *lines[index + 1 :]]

    ids = [v["id"] for _, _, v, _ in found if "id" in v]
    outcomes = [v["name"] for _, tag, v, _ in found if tag == "outcome"]
    single = {"transition", "connection", "param", "outcome", "input", "output", "ext:when"}
    for tag in sorted(single):
        if place := some({tag}):
            yield f"drop {tag}", place[0], [*lines[: place[0]], *lines[place[0] + 1 :]]
            yield (
                f"double {tag}",
                place[0],
                [*lines[: place[0]], lines[place[0]], *lines[place[0] :]],
            )
    nodes = {
        "state",
        "behavior",
        "ext:container",
        "ext:concurrency",
        "ext:priority",
        "ext:condition",
    }
    if place := some(nodes):
        end = end_of(lines, place[0])
        yield "drop element", place[0], [*lines[: place[0]], *lines[end:]]
    renamed = [
        ({"transition"}, "event"), ({"transition"}, "target"), ({"outcome"}, "name"),
        ({"state", "behavior", "ext:container", "ext:concurrency"}, "id"),
        ({"state", "behavior"}, "type"),
        ({"connection"}, "output"), ({"connection"}, "input"), ({"connection"}, "output_state_id"),
        ({"connection"}, "input_state_id"), ({"param"}, "name"), ({"ext:when"}, "state"),
        ({"ext:when"}, "event"), ({"ext:condition"}, "outcome"), ({"input", "output"}, "name"),
        ({"statemachine", "ext:container"}, "initial"),
    ]  # fmt: skip
    for tags, attribute in renamed:
        if place := some(tags, lambda values, a=attribute: a in values):
            line = set_value(lines[place[0]], attribute, f"{place[1][attribute]}x")
            yield changed(f"rename {attribute}", place[0], line)
    if place := some({"transition"}):
        target = pick.choice([*ids, *outcomes])
        yield changed("redirect transition", place[0], set_value(lines[place[0]], "target", target))
    if place := some({"ext:condition"}):
        yield changed(
            "redirect condition",
            place[0],
            set_value(lines[place[0]], "outcome", pick.choice(outcomes)),
        )
    if place := some({"connection"}):
        for end in ("output_state_id", "input_state_id"):
            yield changed(
                f"redirect {end}", place[0], set_value(lines[place[0]], end, pick.choice(ids))
            )
    pair = [some({"connection"}), some({"connection"})]
    if all(pair) and pair[0][0] != pair[1][0]:
        (one, values), (other, others) = pair
        swapped = list(lines)
        swapped[one] = set_value(lines[one], "input", others["input"])
        swapped[other] = set_value(lines[other], "input", values["input"])
        yield "swap inputs", one, swapped
    for attribute in ("ext:attempts", "ext:timeout_s", "ext:on_error", "ext:autonomy", "topic"):
        if place := some(nodes | {"transition"}, lambda values, a=attribute: a in values):
            yield changed(f"drop {attribute}", place[0], drop_attribute(lines[place[0]], attribute))
    if place := some({"ext:container", "statemachine", "ext:priority"}):
        yield changed("restart", place[0], set_value(lines[place[0]], "initial", pick.choice(ids)))
    if place := some({"param"}):
        yield changed(
            "spoil value",
            place[0],
            set_value(lines[place[0]], "value", pick.choice(["many", "[]", "-1", "{}"])),
        )
    if place := some({"input", "output"}, lambda values: "type" in values):
        yield changed(
            "retype", place[0], set_value(lines[place[0]], "type", pick.choice(["dict", "bool"]))
        )


def mutants(golden, seed, wanted):
    pick = random.Random(seed)
    texts = {name: (golden / "charts" / name).read_text() for name in CHARTS}
    seen, made = set(texts.values()), []
    while len(made) < wanted:
        for name, text in texts.items():
            lines = text.splitlines()
            for what, index, after in mutations(lines, pick):
                changed = "\n".join(after) + "\n"
                if changed not in seen and len(made) < wanted:
                    seen.add(changed)
                    found = ELEMENT.match(lines[index])
                    values = dict(ATTRIBUTE.findall(found[2]))
                    is_port = found[1] in ("input", "output")
                    key = values["name"].replace('"', "'") if is_port else "no key"
                    made.append(Mutant(name, what, changed, related(lines, after, index), key=key))
    return made


@pytest.fixture(scope="module")
def kinds(library, golden_behaviors):
    """Return what the nodes of the golden charts offer, found without the checker's resolving."""

    def names(ports):
        is_listed = isinstance(ports, FromParameter)
        return None if is_listed else tuple(port.name for port in ports if not port.optional)

    behaviors = {behavior.class_name: behavior for behavior in library.behaviors}
    behaviors |= {behavior.name: behavior for behavior in library.behaviors}
    states = {state.name: state for state in library.states}
    found = {}
    for name, offered in {**states, **behaviors, **golden_behaviors}.items():
        outcomes = () if isinstance(offered.outcomes, FromParameter) else offered.outcomes
        keeps_time = any(parameter.name == "timeout_s" for parameter in offered.parameters)
        found[name] = Kind(
            outcomes, names(offered.inputs), names(offered.outputs), keeps_time=keeps_time
        )
    return found


@pytest.fixture(scope="module")
def knowledge(library, golden_behaviors, kinds):
    return library, golden_behaviors, kinds


def faults_of(text, kinds):
    """Return what goes wrong in some run of a chart."""
    chart = chart_xml.read_chart({"a.xml": text.encode()}, "a.xml", kinds)
    return explore_all(chart, MOST_STEPS)


def test_the_golden_charts_are_accepted_without_a_warning_and_harmless(golden, knowledge):
    library, charts, kinds = knowledge
    for name in CHARTS:
        text = (golden / "charts" / name).read_text()
        assert check_chart(parse_chart(text, name), library, charts).problems == ()
        assert faults_of(text, kinds) == ()


def verdict(mutant, library, charts, kinds):
    """Return how a mutant fares: refused in its place, elsewhere, harmless, or missed."""
    chart, problems = read_chart(mutant.text, mutant.name)
    if chart is not None:
        problems = (*problems, *check_chart(chart, library, charts).problems)
    errors = errors_in(problems)
    if errors:
        for error in errors:
            if error.position.line in mutant.lines or mutant.key in error.message:
                return "refused"
        return f"refused elsewhere: {errors[0]} not in {sorted(mutant.lines)}"
    faults = faults_of(mutant.text, kinds)
    return f"missed: {faults[0]}" if faults else "harmless"


def verdicts_of(made, knowledge):
    """Return how mutants fare, with what each is; each is refused in its place or harmless."""
    verdicts = [(m.what, m.name, verdict(m, *knowledge)) for m in made]
    assert [v for v in verdicts if v[2] not in ("refused", "harmless")] == []
    return verdicts


def test_a_mutant_is_refused_in_its_place_or_harmless(golden, knowledge, fresh_seed):
    verdicts_of(mutants(golden, fresh_seed, FEW), knowledge)


@pytest.mark.slow
def test_most_of_many_mutants_are_refused(golden, knowledge, fresh_seed):
    made = mutants(golden, fresh_seed, MANY)
    verdicts = verdicts_of(made, knowledge)
    share = Counter(v for _, _, v in verdicts)
    assert share["refused"] > 0.7 * len(made), share
    assert len({what for what, _, _ in verdicts}) >= 40


def goes_wrong(text, kinds):
    """Return whether a run of a chart goes wrong, with its numbers of attempts or with others.

    The checker does not count: that two states have three attempts each may keep one of them from
    ever having had its own, and a chart must not depend on it.
    """
    attempts = re.compile(r'(?<=attempts=")\d+(?=")')
    count = len(attempts.findall(text))
    texts = [text]
    for few in range(count):
        numbers = iter("1" if i == few else "3" for i in range(count))
        texts.append(attempts.sub(lambda _, numbers=numbers: next(numbers), text))
    return any(faults_of(text, kinds) for text in texts)


def test_a_state_that_never_runs_out_of_attempts_as_it_is_goes_wrong_with_others(golden, knowledge):
    exhausted = '<transition event="exhausted" target="{}"/>\n  </state>\n  <state id="Fix"'
    text = (golden / "charts" / "place_connector.xml").read_text()
    looped = text.replace(exhausted.format("failed"), exhausted.format("Insert"))
    assert looped != text
    assert not faults_of(looped, knowledge[2])
    assert goes_wrong(looped, knowledge[2])


@pytest.mark.slow
def test_what_is_reported_to_go_wrong_in_a_run_does_go_wrong(golden, knowledge, fresh_seed):
    """No false alarm: a run-time error of the checker is a fault that the reference finds."""
    library, charts, kinds = knowledge
    run_time_errors = {
        ProblemKind.READ_BEFORE_WRITE,
        ProblemKind.OVERWRITTEN_VALUE,
        ProblemKind.NO_WAY_OUT,
        ProblemKind.ENDLESS_CONTAINER,
        ProblemKind.UNBOUND_INPUT,
    }
    confirmed = 0
    for mutant in mutants(golden, fresh_seed, MANY):
        chart, problems = read_chart(mutant.text, mutant.name)
        if chart is not None and not errors_in(problems):
            errors = errors_in(check_chart(chart, library, charts).problems)
            if errors and {error.code for error in errors} <= run_time_errors:
                assert goes_wrong(mutant.text, kinds), errors[0]
                confirmed += 1
    assert confirmed > 20


def test_a_chart_written_on_one_line_has_the_same_problems(golden, knowledge, fresh_seed):
    library, charts, _kinds = knowledge
    text = (golden / "charts" / "two_arms.xml").read_text()
    twice = text.replace(RIGHT_FAILED, LEFT_FAILED, 1)
    assert twice != text
    doubled = Mutant("two_arms.xml", "an event in two conditions", twice, frozenset(), key="")
    for mutant in [doubled, *mutants(golden, fresh_seed, FEW)]:
        codes = []
        for text in (mutant.text, mutant.text.replace("\n", " ")):
            chart, problems = read_chart(text, mutant.name)
            if chart is not None:
                problems = (*problems, *check_chart(chart, library, charts).problems)
            codes.append(Counter(problem.code for problem in problems))
        assert codes[0] == codes[1], mutant
