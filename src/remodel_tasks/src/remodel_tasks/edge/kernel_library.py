"""Load a compiled kernel, and declare its functions to ctypes."""

from __future__ import annotations

import ctypes
from typing import Any

from remodel_tasks.errors import KernelError


def load_library(name: str) -> ctypes.CDLL:
    """Load a library from where the workspace's setup file says libraries are.

    Args:
        name: of its file.

    Raises:
        KernelError: if it is not there.
    """
    try:
        return ctypes.CDLL(name)
    except OSError as error:
        raise KernelError(
            f"{name} cannot be loaded ({error}): run `make build`, which compiles it with g++, and "
            "source devel/setup.bash"
        ) from error


def declare(library: ctypes.CDLL, *functions: tuple[str, Any, list[Any]]) -> None:
    """Set result and argument types of functions, each given as name, result and arguments."""
    for name, result, arguments in functions:
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
