"""The topics between an engine and those who watch and command it, with their types.

Names are relative: they are resolved in the namespace of the node. Sections are those of the
contract.
"""

from __future__ import annotations

START = "flexbe/start_behavior"
PREEMPT = "flexbe/command/preempt"
AUTONOMY = "flexbe/command/autonomy"
ATTACH = "flexbe/command/attach"
SYNC = "flexbe/command/sync"
TRANSITION = "flexbe/command/transition"
LOCK = "flexbe/command/lock"
UNLOCK = "flexbe/command/unlock"
PAUSE = "flexbe/command/pause"
REPEAT = "flexbe/command/repeat"
REQUEST_STRUCTURE = "flexbe/request_mirror_structure"

COMMANDS = {
    START: "flexbe_msgs/BehaviorSelection",
    PREEMPT: "std_msgs/Empty",
    AUTONOMY: "std_msgs/UInt8",
    ATTACH: "std_msgs/UInt8",
    SYNC: "std_msgs/Empty",
    TRANSITION: "flexbe_msgs/OutcomeRequest",
    LOCK: "std_msgs/String",
    UNLOCK: "std_msgs/String",
    PAUSE: "std_msgs/Bool",
    REPEAT: "std_msgs/Empty",
    REQUEST_STRUCTURE: "std_msgs/Int32",
}

STATUS = "flexbe/status"
FEEDBACK = "flexbe/command_feedback"
HEARTBEAT = "flexbe/heartbeat"
LOG = "flexbe/log"
STRUCTURE = "flexbe/mirror/structure"
MIRROR_SYNC = "flexbe/mirror/sync"
OUTCOME = "flexbe/mirror/outcome"
REQUEST = "flexbe/outcome_request"
CURRENT_STATE = "flexbe/debug/current_state"
UPDATE = "flexbe/behavior_update"

# What the engine itself publishes; UPDATE may be left to a mirror.
PUBLISHED = {
    STATUS: "flexbe_msgs/BEStatus",
    FEEDBACK: "flexbe_msgs/CommandFeedback",
    HEARTBEAT: "std_msgs/Empty",
    LOG: "flexbe_msgs/BehaviorLog",
    STRUCTURE: "flexbe_msgs/ContainerStructure",
    MIRROR_SYNC: "flexbe_msgs/BehaviorSync",
    OUTCOME: "std_msgs/UInt8",
    REQUEST: "flexbe_msgs/OutcomeRequest",
    CURRENT_STATE: "std_msgs/String",
}
WATCHED = {**PUBLISHED, UPDATE: "std_msgs/String"}

# Everything here is expected message by message: nothing more may be published.
STRICT = (STATUS, FEEDBACK, REQUEST)
STRICT_IF_SUPERVISED = (OUTCOME, CURRENT_STATE)

USERDATA_SERVICE = "flexbe/get_userdata"
EXECUTE_ACTION = "flexbe/execute_behavior"
