"""The mirror, at stock FlexBE's import path."""

from flexbe_mirror.ros.mirror_node import FlexbeMirror

__all__ = ["FlexbeMirror"]
