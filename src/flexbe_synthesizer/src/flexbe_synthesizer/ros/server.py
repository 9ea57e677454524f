"""The synthesis action server: requests in a queue, one after another, none able to end it."""

from __future__ import annotations

import queue
import threading
from collections.abc import Sequence

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus
from flexbe_msgs.msg import (
    BehaviorSynthesisAction,
    BehaviorSynthesisFeedback,
    BehaviorSynthesisResult,
    OutcomeCondition,
    StateInstantiation,
    SynthesisErrorCodes,
)

from flexbe_synthesizer.core.instantiate import Instantiation
from flexbe_synthesizer.request import (
    RequestError,
    SynthesisRequest,
    Synthesizer,
    SynthesisErrorCode,
)

ACTION = "flexbe/synthesize"
_MOST_WAITING = 64  # requests; a client with more outstanding is out of order
