"""The picture of one camera on a page."""

from __future__ import annotations

from nicegui.element import Element


class CameraView(Element, component="../static/camera.js"):
    """Shows a picture; the browser fetches it, so that pages are not slowed down."""

    def __init__(self, label: str, none: str) -> None:
        """Show nothing yet under a label; `none` stands where no picture is."""
        super().__init__()
        self._address = ""
        self._props["label"] = label
        self._props["none"] = none

    def show(self, address: str) -> None:
        """Show the picture of an address; an empty one: none."""
        if address != self._address:
            self._address = address
            self.run_method("show", address)
