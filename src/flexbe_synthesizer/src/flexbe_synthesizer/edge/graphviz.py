"""Have Graphviz turn a drawing's text into a picture."""

from __future__ import annotations

import subprocess
from pathlib import Path

from flexbe_synthesizer.errors import DrawingError

FORMATS = (".svg", ".png")
_TIMEOUT_S = 60.0  # a chart of a thousand states takes about ten seconds


def render_dot(dot: str, path: Path) -> None:
    """Write the picture of a DOT text to a path, in the format that its suffix says.

    Raises:
        DrawingError: if the suffix is no format, or Graphviz fails.
    """
    if path.suffix not in FORMATS:
        raise DrawingError(f"{path} cannot be drawn; give a file name that ends in .svg or .png")
    command = ["dot", f"-T{path.suffix[1:]}"]
    if path.suffix == ".png":
        command.append("-Gdpi=144")
    try:
        done = subprocess.run(
            command, input=dot.encode(), capture_output=True, timeout=_TIMEOUT_S, check=True
        )
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(done.stdout)
    except FileNotFoundError as error:
        raise DrawingError("Graphviz is not there; install it: apt-get install graphviz") from error
    except subprocess.CalledProcessError as error:
        reason = error.stderr.decode(errors="replace").strip()
        raise DrawingError(f"Graphviz could not draw {path}: {reason}") from error
    except (OSError, subprocess.TimeoutExpired) as error:
        raise DrawingError(f"{path} could not be drawn: {error}") from error
