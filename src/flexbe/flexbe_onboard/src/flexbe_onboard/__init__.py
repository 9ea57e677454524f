"""The behavior engine as a ROS node."""

from flexbe_onboard.flexbe_onboard import FlexbeOnboard

__all__ = ["FlexbeOnboard"]
