"""The picture of one camera on a page."""

from __future__ import annotations

from nicegui.element import Element

from remodel_console.pictures import Pictures


class CameraView(Element, component="static/camera.js"):
    """Shows the newest picture; the browser fetches it, so that pages are not slowed down."""

    def __init__(self, pictures: Pictures, camera: str, label: str, none: str) -> None:
        """Show a camera under a label; `none` stands where no picture is yet."""
        super().__init__()
        self._pictures = pictures
        self._camera = camera
        self._number = 0
        self._props["label"] = label
        self._props["none"] = none

    def look(self) -> None:
        """Show the newest picture if it is new."""
        picture = self._pictures.newest(self._camera)
        if picture is not None and picture.number != self._number:
            self._number = picture.number
            self.run_method("show", f"/picture/{self._camera}?number={picture.number}")
