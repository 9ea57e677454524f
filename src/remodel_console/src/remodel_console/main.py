"""The console as a program: its options, and how its parts are joined.

The pages are served at once; ROS is joined on a thread as soon as a master is there.
"""

from __future__ import annotations

import argparse
import os
import secrets
import sys
import threading
from collections.abc import Sequence
from pathlib import Path

from nicegui import app

from remodel_console.console import Console
from remodel_console.core.access import Door, is_local
from remodel_console.desk import Desk
from remodel_console.edge.catalogue import Catalogue
from remodel_console.edge.journal import Journal
from remodel_console.edge.workspace import Workspace, chart_folders
from remodel_console.live import Live
from remodel_console.ros.presence import join_ros
from remodel_console.session import Session
from remodel_console.web.server import serve

_PORT = 8765
_JOURNAL = "~/.ros/remodel_console/commands.jsonl"


def main(arguments: Sequence[str]) -> int:
    """Run the console and return the exit code."""
    options = _read_options(arguments)
    try:
        door, journal = _door(options), Journal(Path(options.record).expanduser())
    except (ValueError, OSError) as error:
        sys.stderr.write(f"console: {error}\n")
        return 2
    package_path = os.environ.get("ROS_PACKAGE_PATH", "")
    user_charts = Path(options.user_charts).expanduser()
    workspace = Workspace(chart_folders(package_path, [user_charts]), package_path)
    console = Console(
        door, Desk(journal), Live(), Session(workspace), workspace, Catalogue(package_path)
    )
    end = threading.Event()
    joining = threading.Thread(target=join_ros, args=(console, options.key, journal, end))
    app.on_startup(joining.start)
    app.on_shutdown(end.set)
    _tell_address(door, options.port)
    serve(console, options.port)
    return 0


def _read_options(arguments: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="console", description="The operator console.")
    parser.add_argument(
        "--host", default="127.0.0.1", help="address to bind to; others need a token"
    )
    parser.add_argument("--port", type=int, default=_PORT)
    parser.add_argument("--token", default="", help="opens for operators; made up if needed")
    parser.add_argument("--watch-token", default="", help="opens for people who only watch")
    parser.add_argument("--key", default="", help="what a command of /flexbe/uicommand must bring")
    parser.add_argument("--user-charts", default="~/remodel_charts", help="one more chart folder")
    parser.add_argument("--record", default=_JOURNAL, help="file in which commands are recorded")
    given = [word for word in arguments[1:] if ":=" not in word]  # what roslaunch adds
    return parser.parse_args(given)


def _door(options: argparse.Namespace) -> Door:
    token = options.token
    if not token and not is_local(options.host):
        token = secrets.token_urlsafe(24)
    return Door(options.host, token, options.watch_token)


def _tell_address(door: Door, port: int) -> None:
    """Print where the console is; not through the log, which everybody can read."""
    host = f"[{door.host}]" if ":" in door.host else door.host
    address = f"http://{host}:{port}/"
    if not is_local(door.host):
        sys.stdout.write(
            f"console: WARNING: bound to {door.host}: everybody on the network who has a token can "
            "steer the cell, and the connection is not encrypted\n"
        )
    if door.token:
        address += f"enter?token={door.token}"
    sys.stdout.write(f"console: {address}\n")
    sys.stdout.flush()
