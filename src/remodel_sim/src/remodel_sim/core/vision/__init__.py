"""From pictures to poses and shapes: OpenCV and numpy only."""
