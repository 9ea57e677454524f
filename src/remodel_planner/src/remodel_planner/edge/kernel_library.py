"""Load the compiled kernel, and tell ctypes what its functions take."""

from __future__ import annotations

import ctypes
from typing import Any

from remodel_planner.errors import KernelError

_LIBRARY = "libremodel_planner_kernel.so"


def load_library() -> Any:  # noqa: ANN401 - a ctypes library
    """Load the library from where the workspace's setup file says libraries are.

    Raises:
        KernelError: if it is not there.
    """
    try:
        return ctypes.CDLL(_LIBRARY)
    except OSError as error:
        raise KernelError(
            f"{_LIBRARY} cannot be loaded ({error}): run `make build` and source devel/setup.bash"
        ) from error


def declare(library: Any, *functions: tuple[str, Any, list[Any]]) -> None:  # noqa: ANN401
    """Set result and argument types of functions, each given as name, result and arguments."""
    for name, result, arguments in functions:
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
