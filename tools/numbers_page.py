"""The text of docs/reference/numbers.md, from the code that applies the numbers."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[1]

HEAD = """\
# Numbers of the contracts

How long each side waits for the other one, and what it concludes then. Written by `make generate`
from the modules that apply these numbers. Wall time is the computer's; ROS time is that of
`/clock` where a simulation publishes it.

"""

STATES, SUPERVISION = (
    "remodel_states/src/remodel_states",
    "remodel_supervision/src/remodel_supervision",
)
CORE, WIDGET = "flexbe/flexbe_core/src/flexbe_core", "flexbe/flexbe_widget/src/flexbe_widget"

# What each number means for the other side; where it stands: module below src, constant.
NUMBERS = {
    "Abilities": (
        (
            "a goal has ended this long after its `timeout` at the latest; ROS time",
            f"{STATES}/core/contract.py",
            "GRACE_S",
        ),
        (
            "a cancelled goal has ended; wall time",
            f"{STATES}/core/contract.py",
            "CANCEL_LIMIT_S",
        ),
        (
            "a goal that arrives later is rejected, and one older than its `timeout`; ROS time",
            f"{STATES}/core/contract.py",
            "LATE_S",
        ),
        (
            "clocks of several machines may differ: goals may be older by this",
            f"{STATES}/core/contract.py",
            "CLOCKS_DIFFER_S",
        ),
        (
            "a goal that takes longer has reported feedback; ROS time",
            f"{STATES}/core/contract.py",
            "SILENT_LIMIT_S",
        ),
        (
            "`AbilityServer` repeats feedback while `wait` is called; wall time",
            f"{STATES}/serving.py",
            "_FEEDBACK_S",
        ),
        (
            "`AbilityServer` drops feedback that follows sooner; wall time",
            f"{STATES}/serving.py",
            "_QUIET_S",
        ),
        ("error codes of packages of your own", f"{STATES}/core/tables.py", "OTHER_CODES"),
    ),
    "states": (
        (
            "a server that publishes no status hangs: `command_error`; both times",
            f"{CORE}/proxy/proxy_action_client.py",
            "SILENCE_S",
        ),
        (
            "a server that lists other goals never received this one; wall time",
            f"{CORE}/proxy/proxy_action_client.py",
            "UNNOTICED_S",
        ),
        (
            "a state that asks for the result of a lost goal is ended; wall time",
            f"{CORE}/proxy/proxy_action_client.py",
            "LOST_GRACE_S",
        ),
        (
            "a state asks the supervisor again after HELD; wall time",
            f"{STATES}/line.py",
            "_RETRY_S",
        ),
        (
            "a warning repeats that nothing moves without the supervisor; wall time",
            f"{STATES}/line.py",
            "WARN_EVERY_S",
        ),
    ),
    "Engine": (
        (
            "a state is executed, unless it sets a rate",
            f"{CORE}/engine/definitions.py",
            "DEFAULT_PERIOD_S",
        ),
        (
            "a node warns that simulated time has stopped; wall time",
            f"{CORE}/ros/clock.py",
            "STOPPED_S",
        ),
        (
            "a node ends when the ROS master does not answer; wall time",
            f"{CORE}/ros/master.py",
            "SILENCE_S",
        ),
        (
            "`be_launcher` waits for a free engine, `--wait`; wall time",
            f"{WIDGET}/core/command_line.py",
            "DEFAULT_WAIT_S",
        ),
        (
            "an engine without heartbeat (1 Hz) is gone, for its clients; wall time",
            f"{WIDGET}/core/run_watch.py",
            "SILENCE_S",
        ),
        (
            "the engine has prepared a behavior; wall time",
            f"{WIDGET}/core/run_watch.py",
            "START_LIMIT_S",
        ),
    ),
    "Supervisor": (
        (
            "the synthesizer has made a behavior of a chart; wall time",
            f"{SUPERVISION}/ros/peers/engine_link.py",
            "SYNTHESIS_LIMIT_S",
        ),
        (
            "an engine without a sign is lost, and the task is resumed; wall time",
            f"{SUPERVISION}/ros/peers/engine_link.py",
            "SILENCE_LIMIT_S",
        ),
        (
            "a behavior has stopped when it is asked to; wall time",
            f"{SUPERVISION}/supervisors/task_supervisor.py",
            "STOP_LIMIT_S",
        ),
        (
            "a command of an operator is answered, whatever still moves; wall time",
            f"{SUPERVISION}/supervisors/run_control.py",
            "REST_LIMIT_S",
        ),
        (
            "an ability server that ended has started again; wall time",
            f"{SUPERVISION}/supervisors/failure_judge.py",
            "_GONE_LIMIT_S",
        ),
        (
            "`CheckConnection` gets for the inspection of an end; ROS time",
            f"{SUPERVISION}/ros/peers/engine_link.py",
            "_INSPECTION_S",
        ),
        (
            "the state of a run is published although nothing changed; wall time",
            f"{SUPERVISION}/ros/server/state_publisher.py",
            "_HEARTBEAT_S",
        ),
        (
            "the supervisor tries again to own the cell; wall time",
            f"{SUPERVISION}/supervisors/cell_runs.py",
            "ACQUIRE_EVERY_S",
        ),
        (
            "the supervisor tries again to reach the database; wall time",
            f"{SUPERVISION}/supervisors/run_record.py",
            "RETRY_S",
        ),
        (
            "an escalation hook has delivered an event; wall time",
            f"{SUPERVISION}/edge/escalation_hook.py",
            "DELIVERY_S",
        ),
    ),
    "`conformance`": (
        (
            "a goal that takes less cannot be caught while it runs: not judged; ROS time",
            f"{STATES}/conformance/trial.py",
            "QUICKEST_S",
        ),
        (
            "a server refuses a goal, or is heard to work on it; ROS time",
            f"{STATES}/conformance/trial.py",
            "ANSWER_LIMIT_S",
        ),
        (
            "a server is back after the command of `--restart`; wall time",
            f"{STATES}/conformance/trial.py",
            "RESTART_LIMIT_S",
        ),
        (
            "`elapsed_time` may differ from the time measured, beside a tenth of it; ROS time",
            f"{STATES}/conformance/rules.py",
            "CLOCK_SLACK_S",
        ),
        (
            "feedback sent before the result may arrive after it; ROS time",
            f"{STATES}/conformance/rules.py",
            "LATE_S",
        ),
    ),
}


def numbers_page() -> str:
    """Return the page."""
    parts = [HEAD, "| number | of | what it is | where |\n|---|---|---|---|\n"]
    for section, rows in NUMBERS.items():
        parts += [
            f"| {shown(module, name)} | {section.lower()} | {meaning} "
            f"| [{Path(module).name}](../../src/{module}) |\n"
            for meaning, module, name in rows
        ]
    return "".join(parts)


def shown(module: str, name: str) -> str:
    """Return the value of a constant as a reader wants it."""
    text = (ROOT / "src" / module).read_text(encoding="utf-8")
    match = re.search(rf"^{name}(?:: \w+)? = (?P<value>[\w.(), ]+)$", text, re.MULTILINE)
    if match is None:
        raise ValueError(f"src/{module} has no constant {name}; tools/numbers_page.py lists it")
    if span := re.fullmatch(r"range\((\d+), (\d+)\)", match["value"]):
        return f"{span[1]} to {int(span[2]) - 1}"
    return f"{float(match['value']):g} s"
