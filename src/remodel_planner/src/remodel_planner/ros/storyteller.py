"""Turn what was run and seen into the report's stories: charts drawn, pictures chosen."""

from __future__ import annotations

import base64

import cv2
import numpy as np
from sensor_msgs.msg import Image

from flexbe_synthesizer.core.codec import parse_chart
from flexbe_synthesizer.core.draw import chart_to_dot
from flexbe_synthesizer.edge.graphviz import dot_picture
from remodel_planner.core.run import Operation
from remodel_planner.core.run_report import Drawing, Picture, WireStory
from remodel_planner.core.trace import Trace, trace
from remodel_planner.edge.package_files import behavior_charts
from remodel_planner.ros.task_supervisor import Sight
from remodel_planner.ros.use_case_supervisor import WireRun

_JPEG_QUALITY = 85


class Storyteller:
    """Tells wires' runs with the charts that remodel_behaviors ships."""

    def __init__(self) -> None:
        """Read the charts that tasks nest."""
        path = behavior_charts() / "place_connector.xml"
        chart = parse_chart(path.read_text(encoding="utf-8"), str(path))
        self._nested = {chart.name: chart}

    def story(self, run: WireRun) -> WireStory:
        """Return one wire's story."""
        taken = trace(run.chart, run.execution.operations, self._nested)
        pictures = [
            Picture(_caption(sight, run.execution.operations), _data_uri(sight.image))
            for sight in run.sights
        ]
        pictures.append(Picture("The panel afterwards", _data_uri(run.after)))
        return WireStory(
            run.cut.wire,
            run.cut.length,
            run.execution,
            tuple(_drawings(taken)),
            tuple(pictures),
        )

    def overview(self, image: Image) -> tuple[Picture, ...]:
        """Return the pictures of the whole cell."""
        return (Picture("The cell at the end", _data_uri(image)),)


def _drawings(taken: Trace) -> list[Drawing]:
    caption = f"{taken.chart.name} {taken.path}".strip()
    svg = dot_picture(chart_to_dot(taken.chart, taken.steps), ".svg").decode()
    drawings = [Drawing(caption, svg[svg.index("<svg") :])]
    for child in taken.children:
        drawings += _drawings(child)
    return drawings


def _caption(sight: Sight, operations: tuple[Operation, ...]) -> str:
    """Return which ability made a picture, by the time at which it was made."""
    for operation in operations:
        if operation.ended_s - operation.elapsed_s <= sight.stamp_s <= operation.ended_s:
            return f"{operation.state_path.lstrip('/')}: {sight.camera} camera"
    return f"{sight.camera} camera"


def _data_uri(image: Image) -> str:
    """Return an rgb8 picture as a JPEG data URI."""
    pixels = np.frombuffer(image.data, np.uint8).reshape(image.height, image.width, 3)
    options = [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY]
    _, jpeg = cv2.imencode(".jpg", cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR), options)
    return f"data:image/jpeg;base64,{base64.b64encode(jpeg.tobytes()).decode()}"
