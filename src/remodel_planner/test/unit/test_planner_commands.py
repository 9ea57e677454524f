"""The commands plan, check and sequence: files in, files and exit codes out."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from xml.etree import ElementTree

import pytest
from random_panel import random_panel

from remodel_planner.commands import charts as charts_command
from remodel_planner.commands import check as check_command
from remodel_planner.commands import draw as draw_command
from remodel_planner.commands import explain as explain_command
from remodel_planner.commands import plan as plan_command
from remodel_planner.commands import sequence as sequence_command
from remodel_planner.commands import tasks as tasks_command
from remodel_tasks.core.problem.instance import problem_from
from remodel_tasks.core.search import tables_of
from remodel_tasks.edge.anytime_planner import exchange
from remodel_tasks.edge.search_kernel import Kernel

DATA = Path(__file__).parents[3] / "remodel_cable_tree/test/unit/data"
EXAMPLES = Path(__file__).parents[3] / "remodel_tasks" / "examples"
CABINET = EXAMPLES / "cabinet.yaml"
WAIT_S = 20.0


@pytest.fixture
def instance(tmp_path):
    file = tmp_path / "panel.json"
    file.write_text(json.dumps(random_panel(12, 1, 2)))
    return file


def plan(instance, *options):
    output = instance.with_name("plan.json")
    code = plan_command.main([str(instance), "--output", str(output), *options])
    return code, output


def wanted(file, **sections):
    """Write preferences, and return the options that name them."""
    lines = ["format: remodel-preferences-1"]
    for section, entries in sections.items():
        lines += [f"{section}:", *(f"  - {entry}" for entry in entries)]
    file.write_text("\n".join(lines))
    return ["--preferences", str(file)]


def panel_with(file, *precedence):
    """Write the example of a panel with these order constraints, and return the file's name."""
    data = json.loads((EXAMPLES / "panel.json").read_text())
    file.write_text(json.dumps({**data, "precedence": precedence}))
    return str(file)


def check(instance, file, capsys):
    capsys.readouterr()
    code = check_command.main([str(instance), str(file)])
    return code, capsys.readouterr()


def test_plan_is_written_and_valid(instance, capsys):
    code, output = plan(instance, "--time-limit", "0.05")
    assert code == 0
    printed = capsys.readouterr().out
    code, streams = check(instance, output, capsys)
    verdict = json.loads(streams.out)
    assert (code, verdict["valid"], verdict["violations"]) == (0, True, [])
    assert f"sw2-12-1: cost {verdict['cost']}" in printed
    assert not list(instance.parent.glob(".*"))


@pytest.mark.parametrize("command", ["plan", "sequence"])
def test_without_the_compiled_kernel_a_command_is_refused_in_a_sentence(instance, command):
    program = (
        "import sys; from remodel_planner.commands.options.common import run; "
        f"from remodel_planner.commands.{command} import main; run(main)"
    )
    output = f"--output={instance.with_name('plan.json')}"
    arguments = [str(instance), output] if command == "plan" else [str(DATA / "harness.dzn")]
    done = subprocess.run(
        [sys.executable, "-c", program, *arguments],
        env={**os.environ, "LD_LIBRARY_PATH": ""},
        capture_output=True,
        text=True,
        timeout=WAIT_S,
        check=False,
    )
    assert (done.returncode, done.stdout) == (1, "")
    assert len(done.stderr.splitlines()) == 1
    assert f"{command}: libremodel_" in done.stderr
    assert "run `make build`, which compiles it with g++, and source devel" in done.stderr
    assert not instance.with_name("plan.json").exists()


def test_same_seed_writes_the_same_file(instance, capsys):
    instance.write_text(json.dumps(random_panel(4, 1, 2)))
    texts = []
    for _ in range(2):
        _, output = plan(instance, "--time-limit", "60", "--seed", "5")
        assert "search: done" in capsys.readouterr().out
        texts.append(output.read_bytes())
    assert texts[0] == texts[1]


def test_check_prints_what_a_broken_plan_violates(instance, capsys):
    _, output = plan(instance, "--time-limit", "0")
    document = json.loads(output.read_text())
    document["actions"] = [a for a in document["actions"] if a["a"] != "locate"]
    output.write_text(json.dumps(document))
    code, streams = check(instance, output, capsys)
    assert code == 1
    assert "locating component" in json.loads(streams.out)["violations"][0]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "is no JSON: Expecting property name enclosed in double quotes in line 1, column 2"),
        ("[]", "the document: expected an object, found []"),
        ("[" * 100_000, "is nested too deeply"),
        ("\udcff", "is no UTF-8 text"),
    ],
)
def test_malformed_instances_are_refused(instance, capsys, text, message):
    instance.write_bytes(text.encode("utf-8", "surrogateescape"))
    code, output = plan(instance)
    assert (code, output.exists()) == (1, False)
    error = capsys.readouterr().err
    assert error.startswith(f"plan: {instance}: ")
    assert message in error
    assert check(instance, instance, capsys)[0] == 1


def test_missing_files_are_refused(tmp_path, capsys):
    assert plan(tmp_path / "none.json")[0] == 1
    assert "cannot be read: No such file or directory" in capsys.readouterr().err


def test_output_that_cannot_be_written_is_refused(instance, capsys):
    code = plan_command.main([str(instance), "--output", str(instance / "plan.json")])
    assert code == 1
    assert "plan.json cannot be written: Not a directory" in capsys.readouterr().err


@pytest.mark.parametrize("option", ["--time-limit=-1", "--time-limit=nan", "--seed=-1"])
def test_limits_out_of_range_are_wrong_usage(instance, option):
    with pytest.raises(SystemExit) as caught:
        plan(instance, option)
    assert caught.value.code == 2


def test_a_target_or_the_clock_ends_the_search(instance, capsys, monkeypatch):
    assert plan(instance, "--target", "1000000")[0] == 0
    assert "search: target reached" in capsys.readouterr().out
    monkeypatch.setattr(  # more than any machine does
        "remodel_tasks.core.search.moves_per_second", lambda *_: 1e9
    )
    assert plan(instance, "--time-limit", "0.01")[0] == 0
    assert "search: time limit reached" in capsys.readouterr().out


def test_signal_ends_the_search_with_a_valid_plan(instance, capsys):
    output = instance.with_name("plan.json")
    program = "import sys; from remodel_planner.commands.plan import main; sys.exit(main())"
    instance.write_text(json.dumps(random_panel(100, 1, 2)))
    process = subprocess.Popen(
        [sys.executable, "-c", program, str(instance), "--output", output, "--time-limit=600"],
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        deadline = time.monotonic() + WAIT_S
        while not output.exists() and time.monotonic() < deadline:
            os.sched_yield()
        process.send_signal(signal.SIGINT)
        printed, _ = process.communicate(timeout=WAIT_S)
    finally:
        process.kill()
        process.wait()
    assert process.returncode == 0
    assert "search: stopped by a signal" in printed
    assert check(instance, output, capsys)[0] == 0


def test_sequence_prints_an_order_as_one_object_or_as_text(capsys):
    assert sequence_command.main([str(DATA / "harness.dzn"), "--json", "--time-limit=0.05"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["instance"], found["status"]) == ("harness", "found")
    assert sorted(found["order"]) == list(range(1, 10))
    assert [found["order"][position - 1] for position in found["pos"]] == list(range(1, 10))
    assert sequence_command.main([str(DATA / "harness.dzn"), "--time-limit=0.05"]) == 0
    text = capsys.readouterr().out
    assert "status: found" in text
    assert "order: " in text


def test_sequence_reports_that_there_is_no_order_and_which_constraints_contradict(capsys):
    assert sequence_command.main([str(DATA / "harness_without_order.dzn"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["status"] == "unsatisfiable"
    assert sequence_command.main([str(DATA / "harness_without_order.dzn")]) == 0
    said = capsys.readouterr().out
    assert "no order satisfies all of these constraints:\n  AtomicConstraints, row " in said


def test_sequence_refuses_malformed_files(tmp_path, capsys):
    file = tmp_path / "x.dzn"
    file.write_text("k = 2; b = 3;")
    assert sequence_command.main([str(file)]) == 1
    assert "nothing is assigned to AtomicConstraints" in capsys.readouterr().err


def test_plans_are_drawn_with_every_action_and_wire(instance):
    _, output = plan(instance, "--time-limit", "0")
    drawing = instance.with_name("plan.svg")
    assert draw_command.main([str(instance), str(output), "--output", str(drawing)]) == 0
    root = ElementTree.fromstring(drawing.read_text())
    titles = [element.text for element in root.iter("{http://www.w3.org/2000/svg}title")]
    for action in json.loads(output.read_text())["actions"]:
        assert any(title.startswith(action["a"]) for title in titles)
    for number in range(1, 13):
        assert any(title.startswith(f"{number}: w") for title in titles)


def test_preferences_are_taken_and_explained(instance, capsys):
    entry = "{name: all at once, pick: {heavy: false}, before: {heavy: false}, weight: 1}"
    options = wanted(instance.with_name("preferences.yaml"), prefer=[entry])
    _, output = plan(instance, *options, "--time-limit=0.02")
    capsys.readouterr()
    assert explain_command.main([str(instance), str(output), *options]) == 0
    text = capsys.readouterr().out
    assert "soft constraints violated" in text
    assert "violated, costs 1: `all at once`: w" in text
    assert "right before" in text or "cannot be kept" in text


def test_preferences_about_unknown_wires_are_refused(instance, capsys):
    preferences = instance.with_name("preferences.yaml")
    options = wanted(preferences, require=["{name: x, route: w77, before: w1}"])
    assert plan(instance, *options)[0] == 1
    assert f"plan: {preferences}: require[0].route: no wire w77" in capsys.readouterr().err
    preferences.write_text("a: [")
    assert plan(instance, *options)[0] == 1
    assert "is no YAML: " in capsys.readouterr().err


@pytest.mark.parametrize("command", [explain_command, draw_command])
def test_plans_that_are_not_valid_are_not_worked_on(instance, capsys, command):
    _, output = plan(instance, "--time-limit", "0")
    document = json.loads(output.read_text())
    document["actions"].pop()
    output.write_text(json.dumps(document))
    drawing = instance.with_name("plan.svg")
    rest = ["--output", str(drawing)] if command is draw_command else []
    assert command.main([str(instance), str(output), *rest]) == 1
    assert "the plan is not valid:" in capsys.readouterr().out
    assert command.main([str(output), str(output), *rest]) == 1
    assert not drawing.exists()


def test_tasks_of_an_order_are_printed(instance, capsys):
    assert tasks_command.main([str(CABINET)]) == 0
    printed = capsys.readouterr().out
    assert "W1: Q1:1 to Q2:1, " in printed
    assert "  route: led into the ducts\n    Lay (LayWire), " in printed
    assert tasks_command.main([str(instance)]) == 1
    assert "states a problem, and no tasks to decompose" in capsys.readouterr().err


def test_an_order_is_planned_checked_explained_and_charted(tmp_path, capsys):
    output = tmp_path / "plan.json"
    options = ["--output", str(output), "--time-limit=0.02"]
    assert plan_command.main([str(CABINET), *options]) == 0
    assert check_command.main([str(CABINET), str(output)]) == 0
    assert explain_command.main([str(CABINET), str(output)]) == 0
    assert "W1 right before W2 would cost 1 more in all" in capsys.readouterr().out
    charts = [str(CABINET), str(output), "--output", str(tmp_path / "charts")]
    assert charts_command.main(charts) == 0
    assert capsys.readouterr().out.count(" written\n") == 4
    assert charts_command.main(charts) == 0
    assert capsys.readouterr().out.count(" unchanged\n") == 4
    document = json.loads(output.read_text())
    document["actions"].pop()
    output.write_text(json.dumps(document))
    assert charts_command.main(charts) == 1
    assert charts_command.main([str(CABINET), str(CABINET), "--output", str(tmp_path)]) == 1


@pytest.mark.parametrize("arguments", [["check", "--help"], ["tasks", str(CABINET)]])
def test_a_closed_pipe_ends_a_command_quietly(arguments):
    program = (
        "import sys; from remodel_planner.commands.options.common import run; "
        f"from remodel_planner.commands.{arguments[0]} import main; run(main)"
    )
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run(
        [sys.executable, "-c", program, *arguments[1:]],
        stdout=writer,
        stderr=subprocess.PIPE,
        text=True,
        timeout=WAIT_S,
        check=False,
    )
    os.close(writer)
    assert (done.returncode, done.stderr) == (141, "")


def test_a_plan_with_five_broken_preferences_is_explained_in_words(tmp_path, capsys):
    panel, output = str(EXAMPLES / "panel.json"), str(tmp_path / "plan.json")
    preferences = ["--preferences", str(EXAMPLES / "panel_preferences.yaml")]
    assert plan_command.main([panel, "--output", output, "--time-limit=0.2", *preferences]) == 0
    capsys.readouterr()
    assert explain_command.main([panel, output, *preferences]) == 0
    printed = capsys.readouterr().out
    heads = [line for line in printed.splitlines() if line.startswith("violated, costs ")]
    names = {line.split("`")[1] for line in heads if "`" in line}
    assert len(names) >= 5
    assert "would cost" in printed


def test_requirements_of_a_situation_bind_when_it_is_there(tmp_path, capsys):
    panel, output = str(EXAMPLES / "panel.json"), tmp_path / "plan.json"
    options = ["--preferences", str(EXAMPLES / "panel_preferences.yaml"), "--time-limit=0"]
    while_there = ["--while", "operator in B"]
    assert plan_command.main([panel, "--output", str(output), *options]) == 0
    capsys.readouterr()
    assert check_command.main([panel, str(output), *options[:2], *while_there]) == 1
    assert "out of reach" in capsys.readouterr().out
    assert plan_command.main([panel, "--output", str(output), *options, *while_there]) == 0
    assert check_command.main([panel, str(output), *options[:2], *while_there]) == 0
    assert plan_command.main([panel, "--output", str(output), *options, "--while", "fire"]) == 1
    assert "--while fire: no requirement says so; there are operator in B" in (
        capsys.readouterr().err
    )


def test_requirements_of_an_order_change_how_its_tasks_are_done(tmp_path, capsys):
    output = str(tmp_path / "plan.json")
    for order, requirement, task in (
        ("automotive_harness", "{name: off the rail, avoid_segment: upper}", "W3"),
        ("dialysis_hoses", "{name: gently, insert: H1, force_n: 15}", "H1"),
    ):
        file = str(EXAMPLES / f"{order}.yaml")
        options = wanted(tmp_path / "preferences.yaml", require=[requirement])
        assert plan_command.main([file, "--output", output, "--time-limit=0.02", *options]) == 0
        capsys.readouterr()
        assert explain_command.main([file, output, *options]) == 0
        assert f"`: {task} done by another method or route" in capsys.readouterr().out
        assert tasks_command.main([file, *options]) == 0
        assert requirement.split(",")[0].removeprefix("{name: ") in capsys.readouterr().out


def test_an_infeasible_order_is_explained_by_a_smallest_conflict_and_relaxed(tmp_path, capsys):
    panel, output = panel_with(tmp_path / "panel.json"), tmp_path / "plan.json"
    first, more = tmp_path / "first.yaml", tmp_path / "more.yaml"
    blue, other = (
        "{name: blue first, route: w0, before: w6}",
        "{name: other, route: w7, before: w8}",
    )
    tidy, last = "{name: tidy, route: w6, before: w4}", "{name: last, route: w4, before: w0}"
    arguments = [panel, *wanted(first, require=[blue, other]), *wanted(more, require=[tidy, last])]
    arguments += ["--output", str(output), "--time-limit", "0.05"]
    assert plan_command.main(arguments) == 1
    error = capsys.readouterr().err
    assert "  no plan keeps all of these 3 requirements:\n" in error
    assert f"    `blue first` ({first}, require[0]): route: w0, before: w6\n" in error
    assert f"    `last` ({more}, require[1]): route: w4, before: w0\n" in error
    assert "`other`" not in error
    assert plan_command.main([*arguments, "--relax"]) == 1
    said = capsys.readouterr().out
    for name in ("blue first", "tidy", "last"):
        assert f"without `{name}`: cost " in said
    assert not output.exists()


UNDER = {"type": "under", "before": "w1", "after": "w2"}


def test_contradictions_that_share_no_requirement_are_explained_each(tmp_path, capsys):
    panel = panel_with(tmp_path / "panel.json", UNDER)
    entries = [
        "{name: two first, route: w2, before: w1}",
        "{name: out of reach, arm: L, x_mm: [0, 100]}",
        "{name: four first, route: w4, before: w3}",
        "{name: three first, route: w3, before: w4}",
    ]
    arguments = [panel, *wanted(tmp_path / "all.yaml", require=entries), "--time-limit", "0.05"]
    arguments += ["--output", str(tmp_path / "plan.json"), "--relax"]
    assert plan_command.main(arguments) == 1
    said = capsys.readouterr().out
    assert said.startswith("plan: 3 contradictions that share no requirement\n")
    assert "(w1 before w2: precedence[0]; w2 before w1: `two first`)" in said
    assert "is unreachable: " in said
    assert "limited by `out of reach`\n  and 11 more\n" in said
    assert said.count("  the design contradicts this requirement:\n") == 2
    assert said.count("  no plan keeps all of these 2 requirements:\n") == 1
    for name in ("two first", "out of reach", "four first", "three first"):
        assert f"without `{name}` and the other contradictions: cost " in said


def test_a_design_that_contradicts_itself_is_refused_with_the_places(tmp_path, capsys):
    pin = {"type": "pin", "before": "w2", "before_end": "a", "after": "w1", "after_end": "b"}
    panel = panel_with(tmp_path / "panel.json", UNDER, pin)
    assert plan_command.main([panel, "--output", str(tmp_path / "plan.json")]) == 1
    said = capsys.readouterr().err
    assert "(w1 before w2: precedence[0]; w2 before w1: precedence[1])" in said


def test_check_names_the_requirement_that_a_plan_breaks(tmp_path, capsys):
    panel, output = EXAMPLES / "panel.json", tmp_path / "plan.json"
    arguments = [str(panel), "--output", str(output), "--time-limit", "0.05"]
    assert plan_command.main(arguments) == 0
    picked = [a["wire"] for a in json.loads(output.read_text())["actions"] if a["a"] == "pick"]
    free = [w for w in picked if w in ("w3", "w7", "w13")]
    entry = f"{{name: w goes lowest, route: {free[-1]}, before: {free[0]}}}"
    options = wanted(tmp_path / "wanted.yaml", require=[entry])
    capsys.readouterr()
    assert check_command.main([str(panel), str(output), *options]) == 1
    violations = json.loads(capsys.readouterr().out)["violations"]
    assert any(f"routing wire {free[-1]}, as `w goes lowest` requires," in v for v in violations)


def test_a_search_by_moves_gives_the_same_plan_whatever_the_clock_and_the_cores(
    tmp_path, capsys, monkeypatch
):
    panel = tmp_path / "panel.json"
    panel.write_text(json.dumps(random_panel(30, 3, 2)))
    texts = []
    for cores in ({0}, set(range(8))):
        monkeypatch.setattr(os, "sched_getaffinity", lambda _, cores=cores: cores)
        code, output = plan(panel, "--moves", "3000", "--time-limit", "0")
        assert code == 0
        assert "search: done" in capsys.readouterr().out
        texts.append(output.read_text())
    assert texts[0] == texts[1]
    with pytest.raises(SystemExit) as ended:
        plan(panel, "--moves", "0")
    assert ended.value.code == 2


def test_searches_go_on_from_the_best_plan_of_all():
    problem = problem_from(random_panel(30, 3, 2))
    loaded = Kernel().load(tables_of(problem))
    searches = [loaded.search(seed) for seed in range(3)]
    for search, moves in zip(searches, (10, 3000, 10), strict=True):
        search.construct()
        search.anneal(moves, 20.0, 1.0)
    least = min(search.best()[0] for search in searches)
    assert len({search.best()[0] for search in searches}) > 1
    exchange(searches)
    assert [search.best()[0] for search in searches] == [least] * 3


def test_what_only_orders_need_is_not_loaded_to_plan_and_check_a_problem(instance):
    heavy = ("sqlalchemy", "jsonschema", "lxml", "jinja2", "openpyxl", "rospy", "alembic")
    program = (
        "import sys; from remodel_planner.commands import plan, check\n"
        "file, output = sys.argv[1:]\n"
        "assert plan.main([file, '--output', output, '--time-limit', '0']) == 0\n"
        "assert check.main([file, output]) == 0\n"
        f"print([name for name in {heavy} if name in sys.modules])"
    )
    arguments = [sys.executable, "-c", program, str(instance), str(instance.with_name("p.json"))]
    ended = subprocess.run(arguments, capture_output=True, text=True, timeout=120)
    assert ended.stdout.splitlines()[-1:] == ["[]"], ended.stderr
