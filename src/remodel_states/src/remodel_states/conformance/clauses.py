"""What the contract of all abilities requires, and what is tried.

`make generate` writes docs/reference/conformance.md from these tables.
"""

from __future__ import annotations

from dataclasses import dataclass

from remodel_states.core.contract import CANCEL_LIMIT_S, GRACE_S, SILENT_LIMIT_S

CLAUSES = {
    "no-answer": "Every goal ends with a result.",
    "answers-twice": "A goal gets one result.",
    "open-status": "A result comes with a terminal status of actionlib.",
    "wrong-id": "Result and feedback carry the `id` of their goal.",
    "success-with-code": "A success has `error_code` 0.",
    "failure-without-code": "A failure has an `error_code` other than 0.",
    "status-against-success": "`success` is true with status SUCCEEDED, and with no other.",
    "no-reason": "A failure has a reason, in `error_message` or in the text of its status.",
    "reason-of-success": "A success has no `error_message`.",
    "unknown-code": "Error codes are those of faults.yaml, and of tables that packages export.",
    "wrong-time": "`elapsed_time` [s] of a result is the time from acceptance to result.",
    "percentage-range": "`completed_percentage` is 0 to 100.",
    "percentage-falls": "`completed_percentage` never decreases.",
    "feedback-time": "`elapsed_time` [s] of feedback is finite, not negative, and never decreases.",
    "feedback-after-end": "No feedback follows the result.",
    "no-feedback": f"A goal that takes longer than {SILENT_LIMIT_S:g} s reports feedback.",
    "timeout-ignored": f"A goal ends at most {GRACE_S:g} s after its `timeout`.",
    "timeout-code": "A goal that ends by its `timeout` has `error_code` TIMEOUT (1).",
    "slow-cancel": f"A cancelled goal ends within {CANCEL_LIMIT_S:g} s.",
    "cancel-status": "A cancelled goal ends PREEMPTED or RECALLED.",
    "cancel-code": "A cancelled goal has `error_code` PREEMPTED (2).",
    "foreign-cancel": "A cancel with the id of another goal changes nothing.",
    "accepts-invalid-goal": "An invalid goal is REJECTED before anything moves.",
    "invalid-goal-code": "An invalid goal is rejected with `error_code` INVALID_GOAL (3).",
    "invalid-goal-unnamed": "The reason names the field that is invalid.",
    "accepts-unknown-name": "A goal about something that does not exist fails.",
    "not-back": "A server that was restarted serves goals again.",
    "ghost": "A restarted server does not end the goal of the old one with success.",
}
"""What a server must keep: the name of each clause, and what it requires."""


@dataclass(frozen=True)
class TrialKind:
    """Something that is tried with a server.

    Attributes:
        name: of the trial; those of one field each are named after it.
        sent: what the server gets.
        clauses: those that only this trial judges.
        unjudged: when nothing can be said; empty if it is always judged.
    """

    name: str
    sent: str
    clauses: tuple[str, ...] = ()
    unjudged: str = ""


_ENDED = "the goal takes less than 0.3 s, or ended before"

NOMINAL = TrialKind("a goal that can be done", "the goal of `--goal`")
FEEDBACK = TrialKind(
    "feedback while the ability works",
    "the same goal",
    ("no-feedback",),
    f"the goal takes less than {SILENT_LIMIT_S:g} s",
)
UNKNOWN_CANCEL = TrialKind(
    "a cancel of a goal that was never sent",
    "the goal, and a cancel with another id while it runs",
    ("foreign-cancel",),
    f"{_ENDED} the cancel",
)
TIMEOUT = TrialKind(
    "a timeout shorter than the ability takes",
    "the goal, with half of the time that it took as its `timeout`",
    ("timeout-ignored", "timeout-code"),
    "the goal takes less than 0.3 s, is refused, fails for another reason before its timeout, or "
    f"succeeds within its timeout and the {GRACE_S:g} s after it, as it would if the timeout were "
    "ignored",
)
CANCEL = TrialKind(
    "a cancel while the ability works",
    "the goal, and its cancel after a third of its time; up to three times while it ends late, as "
    "a busy machine may delay messages",
    ("slow-cancel", "cancel-status", "cancel-code"),
    f"{_ENDED} the cancel",
)
TWO_AT_ONCE = TrialKind(
    "a second goal while the first is done",
    "the goal, and the same goal with another id while it runs",
    unjudged=f"{_ENDED} the second one",
)
INVALID_GOAL = TrialKind(
    "an invalid goal",
    "the goal with an empty `id`, with a `timeout` of 0, -1, infinity and NaN, and with NaN in "
    "each other field of numbers",
    ("accepts-invalid-goal", "invalid-goal-code", "invalid-goal-unnamed"),
    "of NaN: the goal has no other field of numbers than `timeout`",
)
UNKNOWN_NAME = TrialKind(
    "a goal with an unknown name",
    "the goal with an unknown name in each field of text but `id`",
    ("accepts-unknown-name",),
    "of a field: it is empty in the goal; of all: the goal has no such field",
)
RESTART = TrialKind(
    "restart of the server",
    "the goal, the command of `--restart`, and the goal again",
    ("not-back",),
    "there is no `--restart`, or the command fails or does not end",
)
OLD_GOAL = TrialKind(
    "the goal that ran during the restart",
    "the first one of these two goals",
    ("ghost",),
    "as above, or the goal ended before the server was restarted",
)
OTHERS = TrialKind("all other trials", "", unjudged="the first goal got no result")

TRIALS = (
    NOMINAL,
    FEEDBACK,
    UNKNOWN_CANCEL,
    TIMEOUT,
    CANCEL,
    TWO_AT_ONCE,
    INVALID_GOAL,
    UNKNOWN_NAME,
    RESTART,
    OLD_GOAL,
)
"""All trials, in their order."""
