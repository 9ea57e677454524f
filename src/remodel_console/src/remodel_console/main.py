"""The console as a program: its options, and how its parts are joined.

The pages are served at once; ROS is joined on a thread as soon as a master is there.
"""

from __future__ import annotations

import argparse
import os
import sys
import threading
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from nicegui import app

from remodel_console.console import Console
from remodel_console.core.access import Door, is_local
from remodel_console.desk import Desk
from remodel_console.edge.catalogue import Catalogue
from remodel_console.edge.journal import Journal
from remodel_console.edge.log_file import LogFile
from remodel_console.edge.scene_files import SceneFiles
from remodel_console.edge.settings_file import SettingsFile
from remodel_console.edge.token_file import read_tokens
from remodel_console.edge.workspace import OUTPUT, Workspace
from remodel_console.errors import CommandError
from remodel_console.live import Live
from remodel_console.ros.presence import join_ros
from remodel_console.session import Session
from remodel_console.sessions import Sessions
from remodel_console.web.server import serve

_PORT = 8765
_JOURNAL = "~/.ros/remodel_console/commands.jsonl"
_SETTINGS = "~/.ros/remodel_console/settings.json"
_LOG = "~/.ros/remodel_console/log.jsonl"
_SCENES = "~/.ros/remodel_console/scenes"
_TOKENS = "~/.ros/remodel_console/tokens.json"
_KEY_VARIABLE = "REMODEL_CONSOLE_KEY"  # other users see a command line, but no environment


def main(arguments: Sequence[str]) -> int:
    """Run the console and return the exit code."""
    options = _read_options(arguments)
    try:
        door, journal = _door(options), Journal(Path(options.record).expanduser())
        log, settings = LogFile(Path(options.log).expanduser()), _settings(options)
    except (ValueError, OSError, CommandError) as error:
        sys.stderr.write(f"console: {error}\n")
        return 2
    package_path = os.environ.get("ROS_PACKAGE_PATH", "")
    user_charts = Path(options.user_charts).expanduser()
    workspace = Workspace(
        package_path,
        lambda: (user_charts, *map(Path, settings.now.chart_folders)),
        options.output,
    )
    sessions = Sessions(lambda: Session(workspace, lambda: settings.now))
    console = Console(
        door,
        Desk(journal),
        live=Live(log),
        sessions=sessions,
        workspace=workspace,
        catalogue=Catalogue(package_path),
        settings=settings,
        scenes=SceneFiles(Path(options.scenes).expanduser()),
    )
    end = threading.Event()
    joining = threading.Thread(target=join_ros, args=(console, journal, end))
    app.on_startup(joining.start)
    app.on_shutdown(end.set)
    _print_address(door, options.port)
    serve(console, options.port)
    return 0


def _read_options(arguments: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="console", description="The operator console.")
    parser.add_argument(
        "--host", default="127.0.0.1", help="address to bind to; others need a token"
    )
    parser.add_argument("--port", type=int, default=_PORT, help="port of the pages")
    parser.add_argument(
        "--tokens",
        default="",
        help="file with the tokens that grant access, written if it is not there; "
        f"on another address than 127.0.0.1: {_TOKENS}",
    )
    parser.add_argument(
        "--key",
        default=os.environ.get(_KEY_VARIABLE, ""),
        help="key that every command of /flexbe/uicommand must contain; "
        f"by default that in the environment, {_KEY_VARIABLE}",
    )
    parser.add_argument("--user-charts", default="~/remodel_charts", help="one more chart folder")
    parser.add_argument(
        "--output", default=OUTPUT, help="package for the behaviors of charts outside any package"
    )
    parser.add_argument("--settings", default=_SETTINGS, help="file that keeps the configuration")
    parser.add_argument("--log", default=_LOG, help="file that keeps the last lines of the log")
    parser.add_argument("--record", default=_JOURNAL, help="file in which commands are recorded")
    parser.add_argument(
        "--scenes", default=_SCENES, help="folder of the recordings of the cell for Replay"
    )
    given = [word for word in arguments[1:] if ":=" not in word]  # what roslaunch adds
    return parser.parse_args(given)


def _door(options: argparse.Namespace) -> Door:
    if not options.tokens and is_local(options.host):
        return Door(options.host)
    return Door(options.host, *read_tokens(Path(options.tokens or _TOKENS).expanduser()))


def _settings(options: argparse.Namespace) -> SettingsFile:
    """Return what is configured; a key that is given at the start becomes part of it."""
    package_path = os.environ.get("ROS_PACKAGE_PATH", "")
    settings = SettingsFile(Path(options.settings).expanduser(), package_path)
    if options.key:
        settings.change(lambda now: replace(now, command_key=options.key))
    return settings


def _print_address(door: Door, port: int) -> None:
    """Print the address of the console; not to the log, which every user can read."""
    host = f"[{door.host}]" if ":" in door.host else door.host
    address = f"http://{host}:{port}/"
    if not is_local(door.host):
        sys.stdout.write(
            f"console: WARNING: bound to {door.host}: everybody on the network who has a token can "
            "command the cell, and the connection is not encrypted\n"
        )
    if door.token:
        address += f"enter?token={door.token}"
    sys.stdout.write(f"console: {address}\n")
    sys.stdout.flush()
