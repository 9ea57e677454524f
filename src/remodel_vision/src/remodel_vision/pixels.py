"""The type of pictures. OpenCV's stubs promise no type of the elements: docstrings state it."""

from typing import Any

import numpy.typing as npt

Pixels = npt.NDArray[Any]
