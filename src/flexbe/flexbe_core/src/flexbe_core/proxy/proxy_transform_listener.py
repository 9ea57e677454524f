"""Look up transforms from a state."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

if TYPE_CHECKING:
    import tf


class ProxyTransformListener:
    """A handle on the transform listener of the process."""

    _listener: ClassVar[tf.TransformListener | None] = None

    def listener(self) -> tf.TransformListener:
        """Return the listener, made when first asked for: most behaviors need none."""
        if ProxyTransformListener._listener is None:
            import tf

            ProxyTransformListener._listener = tf.TransformListener()
        return ProxyTransformListener._listener
