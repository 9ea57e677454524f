"""Rules that a wrong engine breaks, one at a time, and what engine_conformance reports of it."""

import copy

from flexbe_msgs.msg import BehaviorExecutionResult, BEStatus, CommandFeedback
from wrong_engine import EXECUTE

from flexbe_testing.core import topics
from flexbe_testing.core.scenario import checksum
from flexbe_testing.ros.conformance import behavior_package

PACKAGE = "flexbe_conformance_behaviors"
CHAIN = "conformance_chain_sm"


# How a message is changed


def changed(condition=lambda message: True, **fields):
    """Replace fields of the messages that meet a condition; a callable gets the old value."""

    def change(message, engine):
        if not condition(message):
            return [message]
        result = copy.copy(message)
        for name, value in fields.items():
            old = getattr(message, name)
            setattr(result, name, value(old) if callable(value) else value)
        return [result]

    return change


def dropped(condition=lambda message: True):
    return lambda message, engine: [] if condition(message) else [message]


def doubled(condition=lambda message: True):
    return lambda message, engine: [message] * (2 if condition(message) else 1)


def only_answered(command, args):
    """Answer a command, and do nothing."""

    def change(message, engine):
        engine.outward(topics.FEEDBACK, CommandFeedback(command, args(message)))
        return []

    return change


def status(code):
    return lambda message: message.code == code


def feedback(command):
    return lambda message: message.command == command


def logged(word):
    return lambda message: f"conformance: {word}" in message.text


def lenient(message, engine):
    """Run the chain, whatever was asked for."""
    text = (behavior_package() / "src" / PACKAGE / f"{CHAIN}.py").read_text()
    message.behavior_id, message.behavior_checksum = checksum(f"{PACKAGE}.{CHAIN}"), checksum(text)
    message.modifications = []
    return [message]


def every_second(message, engine):
    engine.memory["starts"] = engine.memory.get("starts", 0) + 1
    return [message] if engine.memory["starts"] % 2 else []


def remembered(topic):
    """Remember that a command came."""

    def change(message, engine):
        engine.memory[topic] = message
        return [message]

    return change


def recalled(topic):
    """Repeat a remembered command at each start."""

    def change(message, engine):
        if message.code == BEStatus.STARTED and topic in engine.memory:
            engine.inward(topic, engine.memory[topic])
        return [message]

    return change


def also_left(message, engine):
    engine.inward("conformance/left", message)
    return [message]


def ended_by(code):
    return changed(status(BEStatus.FINISHED), code=code)


def shown_as(text):
    def change(response, engine):
        for info in response.userdata:
            info.data = text
        return response

    return change


def always_found(response, engine):
    response.success = True
    return response


def succeeding(message, engine):
    """Report a rejected or aborted goal as succeeded, in results and in lists of statuses."""
    for status in message.status_list if hasattr(message, "status_list") else [message.status]:
        status.status = 3 if status.status > 3 else status.status
    return [message]


LOCKED = only_answered("lock", lambda m: [m.data or "/Box/Inner/Leaf"] * 2)
LEVEL_0 = changed(autonomy_level=0)
LEVEL_UP = changed(lambda m: m.autonomy_level < 255, autonomy_level=lambda level: level + 1)
UNSUPERVISED = changed(autonomy_level=255)
SUPERVISED = changed(autonomy_level=3)
SYNC_ELSEWHERE = changed(current_state_checksum=lambda value: value ^ 1)
NEXT_OUTCOME = changed(data=lambda index: index ^ 1)

# (faults, scenario -> what its reason contains). A scenario is judged to fail with these faults.
RULES = [
    (
        {topics.STATUS: changed(status(BEStatus.STARTED), behavior_id=7)},
        {"runs-behaviors": "behavior_id: 7"},
    ),
    ({topics.STATUS: changed(status(BEStatus.FINISHED), args=[])}, {"runs-to-the-end": "args: []"}),
    (
        {topics.STATUS: recalled(topics.PAUSE), topics.PAUSE: remembered(topics.PAUSE)},
        {"commands-end-with-the-run": "within"},  # it does not enter, or does not leave, /First
    ),
    (
        {topics.STATUS: recalled(topics.PREEMPT), topics.PREEMPT: remembered(topics.PREEMPT)},
        {"preempt-while-idle": ""},
    ),
    ({topics.STATUS: dropped(status(BEStatus.SWITCHING))}, {"switch-keeps-the-state": "'code': 6"}),
    ({topics.STATUS: ended_by(BEStatus.SWITCHING)}, {"switch-to-another-is-refused": "code: 6"}),
    ({topics.HEARTBEAT: lambda message, engine: [message] * 5}, {"heartbeat": "one beat per 0.0"}),
    (
        {topics.LOG: doubled(logged("exit"))},
        {"order-of-events": "exit", "concurrency-ends-the-others": "2 times"},
    ),
    (
        {topics.LOG: dropped(logged("stop"))},
        {"preempt-supervised": "no 'stop", "concurrency-is-preempted": "no 'stop"},
    ),
    ({topics.LOG: dropped(logged("pause"))}, {"priority-pauses-siblings": "pause /Both/Calm"}),
    ({topics.START: every_second}, {"next-behavior-at-once": "nothing on flexbe/status"}),
    (
        {topics.START: changed(arg_values=[], arg_keys=[])},
        {
            "parameter-types": "word is 'part'",
            "parameter-paths": "word",
            "create-raises": "code: 0",
            "bad-parameter-value": "code: 0",
            "on-start-raises": "flexbe/status",
        },
    ),
    (
        {topics.START: dropped(lambda m: "no_such_key" in m.arg_keys)},
        {"parameter-unknown": "nothing on flexbe/status"},
    ),
    (
        {topics.START: changed(input_keys=[], input_values=[])},
        {"inputs": "pins is None", "userdata-is-remapped": "made of nothing"},
    ),
    (
        {topics.START: lenient},
        {
            "unknown-behavior": "code: 0",
            "other-checksum": "code: 0",
            "modifications": "flexbe/status",
            "switch-to-unknown-is-refused": "switch",
        },
    ),
    ({topics.START: SUPERVISED}, {"unsupervised-is-silent": "", "preempt-unsupervised": "preempt"}),
    (
        {topics.START: LEVEL_0},
        {
            "transition-below-level": "mirror/outcome",
            "structure-request-supervises": "mirror/outcome",
        },
    ),
    (
        {topics.START: LEVEL_UP},
        {
            "transition-at-level-asks": "outcome_request",
            "level-0-blocks-off": "outcome_request",
            "request-is-withdrawn": "outcome_request",
            "request-is-changed": "outcome_request",
        },
    ),
    ({topics.START: UNSUPERVISED}, {"raising-state-is-held": "", "undeclared-outcome-is-held": ""}),
    (
        {topics.AUTONOMY: only_answered("autonomy", lambda m: [])},
        {"level-is-changed": "mirror/outcome"},
    ),
    ({topics.REQUEST: dropped()}, {"breakpoint": "outcome_request"}),
    ({topics.REQUEST: dropped(lambda m: m.outcome == 255)}, {"request-is-withdrawn": "255"}),
    (
        {topics.REQUEST: doubled()},
        {"transition-at-level-asks": "was published although it was asked already"},
    ),
    (
        {topics.TRANSITION: only_answered("transition", lambda m: [m.target, m.target])},
        {"forced-transition": "exit /First", "forced-transition-while-locked": "mirror/outcome"},
    ),
    (
        {topics.TRANSITION: changed(target="First")},
        {"forced-transition-elsewhere": "['First', 'First']"},
    ),
    (
        {topics.TRANSITION: changed(target="Left")},
        {"concurrency-supervises-the-first": "['Left', 'Left']"},
    ),
    (
        {topics.TRANSITION: changed(outcome=lambda index: index % 2)},
        {"forced-outcome-unknown": "left although it has no such outcome"},
    ),
    ({topics.PAUSE: only_answered("pause", lambda m: [])}, {"pause-and-resume": "pause /First"}),
    ({topics.FEEDBACK: dropped(feedback("preempt"))}, {"preempt-while-paused": "preempt"}),
    ({topics.REPEAT: only_answered("repeat", lambda m: [])}, {"repeat": "exit /First"}),
    (
        {topics.LOCK: LOCKED},
        {
            "lock-a-state": "although it is locked",
            "lock-the-active-state": "although it is locked",
            "lock-a-container": "its container is locked",
            "preempt-while-locked": "although it is locked",
            "lock-elsewhere": "/Nowhere",
            "paths-are-of-labels": "Conformance Nest",
        },
    ),
    (
        {topics.FEEDBACK: changed(feedback("unlock"), args=["/First", "/First"])},
        {"unlock-nothing": "/First"},
    ),
    ({topics.FEEDBACK: changed(feedback("attach"), args=[])}, {"attach": "attach"}),
    (
        {topics.STRUCTURE: changed(containers=lambda parts: parts[1:])},
        {"structure": "paths", "outcomes-lead-a-mirror": "paths"},
    ),
    (
        {topics.OUTCOME: NEXT_OUTCOME},
        {"outcomes-lead-a-mirror": "enter", "transition-below-level": "data: 1"},
    ),
    (
        {topics.MIRROR_SYNC: SYNC_ELSEWHERE},
        {"sync": "mirror/sync", "sync-after-concurrency": "mirror/sync", "attach": "mirror/sync"},
    ),
    ({"conformance/right": also_left}, {"concurrency-waits-for-all": "one of two children"}),
    ({topics.USERDATA_SERVICE: shown_as("gold")}, {"get-userdata": "gold"}),
    ({topics.USERDATA_SERVICE: always_found}, {"get-userdata-fails": "success while nothing runs"}),
    (
        {f"{EXECUTE}/status": succeeding, f"{EXECUTE}/result": succeeding},
        {"action-unknown-behavior": "goal status 3", "action-is-aborted": "goal status 3"},
    ),
    (
        {f"{EXECUTE}/result": changed(result=BehaviorExecutionResult(outcome="finished"))},
        {"action-succeeds": "outcome 'finished'"},
    ),
    ({f"{EXECUTE}/cancel": dropped()}, {"action-is-cancelled": "flexbe/status"}),
]
