"""From pictures to things: OpenCV and numpy only."""
