"""The error codes of all abilities, as in remodel_msgs/ErrorCode (a test holds the two equal)."""

from enum import IntEnum


class Code(IntEnum):
    """Why an ability failed; meaning and remedy of each: remodel_msgs/config/error_codes.yaml."""

    NONE = 0
    TIMEOUT = 1
    PREEMPTED = 2
    INVALID_GOAL = 3
    SERVER_LOST = 4
    INTERNAL = 5
    BUSY = 6
    SERVER_HUNG = 7
    CONTRADICTORY_RESULT = 8
    COMPONENT_NOT_FOUND = 100
    COMPONENT_OCCLUDED = 101
    COMPONENT_DISPLACED = 102
    COMPONENT_MISSING = 103
    CABLE_NOT_FOUND = 110
    CABLE_TRUNCATED = 111
    CABLE_AMBIGUOUS = 112
    TIP_NOT_FOUND = 113
    CABLE_OCCLUDED = 114
    OTHER_CABLE_SEEN = 115
    GRASP_MISSED = 200
    GRASP_SLIPPED = 201
    NOTHING_HELD = 202
    OTHER_CABLE_HELD = 203
    TWO_CABLES_HELD = 204
    INSERTION_MISALIGNED = 300
    INSERTION_JAMMED = 301
    INSERTION_NO_CONTACT = 302
    SLIPPED_IN_GRIP = 303
    NOT_SEATED = 304
    PULLED_OUT = 305
    EXTRACTION_STUCK = 306
    MOTION_FAULT = 307
    INSUFFICIENT_FORCE = 308
    SNAGGED = 309
    OUT_OF_DUCT = 310
    UNKNOWN_NAME = 400
    UNREACHABLE = 401
    TERMINAL_OCCUPIED = 402
    WIRE_NOT_FED = 403
    ROBOT_IN_THE_WAY = 404
