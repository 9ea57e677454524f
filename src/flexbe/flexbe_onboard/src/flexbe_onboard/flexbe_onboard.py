"""The engine for programs that embed it, at stock FlexBE's import path and with its defaults."""

from __future__ import annotations

from flexbe_core import BehaviorLibrary
from flexbe_onboard.ros.engine_node import EngineNode, read_options


class FlexbeOnboard(EngineNode):
    """The behavior engine in the calling program's node.

    As in stock FlexBE, and unlike the node of behavior_onboard.launch, it applies source changes
    in requests unless `~modifications` is false: the embedding program decides who may send them.
    """

    def __init__(self) -> None:
        """Advertise everything, and publish that the engine is ready.

        Raises:
            OptionError: if a private parameter of the node is invalid.
        """
        super().__init__(read_options(modifications=True))

    @property
    def _behavior_lib(self) -> BehaviorLibrary:
        """The behaviors that it finds; tests of stock FlexBE add their own."""
        return self._library
