"""Follow the running behavior."""

from flexbe_mirror.flexbe_mirror import FlexbeMirror

__all__ = ["FlexbeMirror"]
