"""The topics of FlexBE's wire protocol between a running behavior and its operators.

Names are relative: they are resolved in the namespace of the node.
"""

from __future__ import annotations

from flexbe_msgs.msg import BehaviorSync, CommandFeedback, ContainerStructure, OutcomeRequest
from std_msgs.msg import Bool, Empty, Int32, String, UInt8

COMMAND_FEEDBACK = "flexbe/command_feedback"
MIRROR_STRUCTURE = "flexbe/mirror/structure"
MIRROR_SYNC = "flexbe/mirror/sync"
MIRROR_OUTCOME = "flexbe/mirror/outcome"
# Not stock FlexBE's: the path of the active state of a supervised run, empty after it.
ACTIVE_STATE = "flexbe/mirror/active_state"
# Not stock FlexBE's: the autonomy level of the run, 255 without supervision.
AUTONOMY_IN_FORCE = "flexbe/mirror/autonomy"
# Not stock FlexBE's: what states find in the userdata and leave behind, see engine/visit.py.
VISITS = "flexbe/mirror/visits"
OUTCOME_REQUEST = "flexbe/outcome_request"
CURRENT_STATE = "flexbe/debug/current_state"
BEHAVIOR_UPDATE = "flexbe/behavior_update"

PUBLISHED = {
    COMMAND_FEEDBACK: CommandFeedback,
    MIRROR_STRUCTURE: ContainerStructure,
    MIRROR_SYNC: BehaviorSync,
    MIRROR_OUTCOME: UInt8,
    OUTCOME_REQUEST: OutcomeRequest,
    CURRENT_STATE: String,
    BEHAVIOR_UPDATE: String,
}

PREEMPT = "flexbe/command/preempt"
# Spelled as in Deliverable 5.1, chapter 5; stock FlexBE listens on the other only.
PREEMPT_OF_DELIVERABLE = "flexbe/commands/preempt"
AUTONOMY = "flexbe/command/autonomy"
ATTACH = "flexbe/command/attach"
SYNC = "flexbe/command/sync"
REQUEST_STRUCTURE = "flexbe/request_mirror_structure"

TRANSITION = "flexbe/command/transition"
LOCK = "flexbe/command/lock"
UNLOCK = "flexbe/command/unlock"
PAUSE = "flexbe/command/pause"
REPEAT = "flexbe/command/repeat"

COMMANDS = {
    PREEMPT: Empty,
    PREEMPT_OF_DELIVERABLE: Empty,
    AUTONOMY: UInt8,
    ATTACH: UInt8,
    SYNC: Empty,
    REQUEST_STRUCTURE: Int32,
    TRANSITION: OutcomeRequest,
    LOCK: String,
    UNLOCK: String,
    PAUSE: Bool,
    REPEAT: Empty,
}

# Key among a start request's parameters, which none of a behavior can have: path of the state to
# start at.
START_AT = "@start_at"
BREAKPOINTS_PARAMETER = "/flexbe/breakpoints"
