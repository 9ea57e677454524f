"""The console as a program: its options, and how its parts are joined.

The pages are served at once; ROS is joined on a thread as soon as a master is there.
"""

from __future__ import annotations

import argparse
import os
import secrets
import sys
import tempfile
import threading
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from nicegui import app

from remodel_console.console import Console
from remodel_console.core.commands import Door, is_local
from remodel_console.edge.kept_files import HandWires, Journal, LogFile, SceneFiles, SettingsFile
from remodel_console.edge.order_drafts import OrderDrafts
from remodel_console.edge.processes import DATABASE_VARIABLE, Everything, PlannerProcess
from remodel_console.edge.users_file import USERS, UsersFile
from remodel_console.edge.workspace import OUTPUT, Catalogue, Workspace, lock_parsing
from remodel_console.errors import CommandError
from remodel_console.live import Desk, Live
from remodel_console.ros.presence import join_ros
from remodel_console.session import Session, Sessions
from remodel_console.web.server import serve

_PORT = 8765
_JOURNAL = "~/.ros/remodel_console/commands.jsonl"
_SETTINGS = "~/.ros/remodel_console/settings.json"
_HAND_WIRES = "hand_wires.json"  # beside the settings
_LOG = "~/.ros/remodel_console/log.jsonl"
_EVERYTHING = "~/.ros/remodel_console/everything"
_SCENES = "~/.ros/remodel_console/scenes"
_KEY_VARIABLE = "REMODEL_CONSOLE_KEY"  # other users see a command line, but no environment


def main(arguments: Sequence[str]) -> int:
    """Run the console and return the exit code."""
    options = _read_options(arguments)
    lock_parsing()
    try:
        users = _users(options)
        door, journal = (
            _door(options, has_users=users is not None),
            Journal(Path(options.record).expanduser()),
        )
        log, settings = LogFile(Path(options.log).expanduser()), _settings(options)
        hand_wires = HandWires(Path(options.settings).expanduser().with_name(_HAND_WIRES))
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
    sessions = Sessions(
        lambda: Session(workspace, lambda: settings.now),
        Session(workspace, lambda: settings.now, opens_drafts=False),
    )
    planner = PlannerProcess()
    drafts = OrderDrafts(
        Path(tempfile.gettempdir()) / f"remodel_orders_{secrets.token_hex(8)}", planner
    )
    everything = Everything(Path(options.everything).expanduser(), planner)
    console = Console(
        door,
        Desk(journal),
        live=Live(log),
        sessions=sessions,
        workspace=workspace,
        catalogue=Catalogue(package_path),
        settings=settings,
        drafts=drafts,
        hand_wires=hand_wires,
        own_database=options.database,
        everything=everything,
        users=users,
        scenes=SceneFiles(Path(options.scenes).expanduser()),
    )
    end = threading.Event()
    joining = threading.Thread(target=join_ros, args=(console, journal, end))
    app.on_startup(joining.start)
    app.on_shutdown(end.set)
    app.on_shutdown(everything.stop)
    app.on_shutdown(planner.end)
    app.on_shutdown(drafts.end)
    _print_address(door, options.port)
    serve(console, options.port, users)
    return 0


def _read_options(arguments: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="console", description="The operator console.")
    parser.add_argument("--host", default="127.0.0.1", help="address to bind to; others need users")
    parser.add_argument("--port", type=int, default=_PORT, help="port of the pages")
    parser.add_argument(
        "--users",
        default="",
        help="file of the users, which `rosrun remodel_console users` writes; without one, "
        "everybody on this computer may do everything (on another address than 127.0.0.1: "
        f"{USERS})",
    )
    parser.add_argument(
        "--user-header",
        default="",
        metavar="NAME",
        help="header in which a reverse proxy names the user, such as X-Forwarded-User",
    )
    parser.add_argument(
        "--proxy",
        action="append",
        default=[],
        metavar="ADDRESS",
        help="address of the proxy; may be repeated (default: this computer)",
    )
    parser.add_argument(
        "--public-host",
        action="append",
        default=[],
        metavar="NAME",
        help="host name by which the proxy's users reach the console; may be repeated",
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
    parser.add_argument(
        "--database",
        metavar="URL",
        default=os.environ.get(DATABASE_VARIABLE, ""),
        help="production database of the supervisor, in which the order desk stores orders; by "
        f"default that in the environment, {DATABASE_VARIABLE}",
    )
    parser.add_argument("--settings", default=_SETTINGS, help="file that keeps the configuration")
    parser.add_argument("--log", default=_LOG, help="file that keeps the last lines of the log")
    parser.add_argument("--record", default=_JOURNAL, help="file in which commands are recorded")
    parser.add_argument(
        "--everything",
        default=_EVERYTHING,
        help="folder of what the console starts where nothing runs",
    )
    parser.add_argument(
        "--scenes", default=_SCENES, help="folder of the recordings of the cell for Replay"
    )
    given = [word for word in arguments[1:] if ":=" not in word]  # what roslaunch adds
    return parser.parse_args(given)


def _users(options: argparse.Namespace) -> UsersFile | None:
    """Return the users; None if everybody on this computer may do everything."""
    default = Path(USERS).expanduser()
    if options.users:
        return UsersFile(Path(options.users).expanduser())
    if is_local(options.host) and not options.user_header:
        return None
    return UsersFile(default) if default.exists() else None


def _door(options: argparse.Namespace, *, has_users: bool) -> Door:
    door = Door(
        options.host,
        has_users,
        options.user_header,
        public_hosts=tuple(filter(None, options.public_host)),
    )
    return replace(door, proxies=tuple(options.proxy)) if options.proxy else door


def _settings(options: argparse.Namespace) -> SettingsFile:
    """Return what is configured; a key that is given at the start becomes part of it."""
    package_path = os.environ.get("ROS_PACKAGE_PATH", "")
    settings = SettingsFile(Path(options.settings).expanduser(), package_path)
    if options.key:
        settings.change(lambda now: replace(now, command_key=options.key))
    return settings


def _print_address(door: Door, port: int) -> None:
    """Print the address of the console."""
    host = f"[{door.host}]" if ":" in door.host else door.host
    address = f"http://{host}:{port}/"
    if not is_local(door.host):
        sys.stdout.write(
            f"console: WARNING: bound to {door.host}: the connection is not encrypted, so "
            "passwords can be read on the network; put a reverse proxy with TLS in front "
            "(--user-header)\n"
        )
    sys.stdout.write(f"console: {address}\n")
    sys.stdout.flush()
