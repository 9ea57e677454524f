"""Have Graphviz turn a drawing's text into a picture."""

from __future__ import annotations

import subprocess
from pathlib import Path

from flexbe_synthesizer.edge.files import write_all
from flexbe_synthesizer.errors import DrawingError, OutputError

FORMATS = (".svg", ".png")
_TIMEOUT_S = 60.0  # a chart of a thousand states takes about ten seconds


def dot_picture(dot: str, suffix: str) -> bytes:
    """Return the picture of a DOT text in the format that a file suffix names.

    Raises:
        DrawingError: if the suffix is no format, or Graphviz fails.
    """
    if suffix not in FORMATS:
        raise DrawingError(f"unknown suffix {suffix!r} of a picture; allowed: .svg, .png")
    command = ["dot", f"-T{suffix[1:]}"]
    if suffix == ".png":
        command.append("-Gdpi=144")
    try:
        done = subprocess.run(
            command, input=dot.encode(), capture_output=True, timeout=_TIMEOUT_S, check=True
        )
    except FileNotFoundError as error:
        raise DrawingError(
            "Graphviz is not installed; install it: apt-get install graphviz"
        ) from error
    except subprocess.CalledProcessError as error:
        reason = error.stderr.decode(errors="replace").strip()
        raise DrawingError(f"Graphviz failed: {reason}") from error
    except subprocess.TimeoutExpired as error:
        raise DrawingError(f"Graphviz took more than {_TIMEOUT_S:.0f} s") from error
    return done.stdout


def render_dot(dot: str, path: Path) -> None:
    """Write the picture of a DOT text to a path, in the format that its suffix says.

    Raises:
        DrawingError: if the suffix is no format, Graphviz fails, or the file can't be written.
    """
    try:
        write_all({path: dot_picture(dot, path.suffix)})
    except (DrawingError, OutputError) as error:
        raise DrawingError(f"{path} could not be drawn: {error}") from error
