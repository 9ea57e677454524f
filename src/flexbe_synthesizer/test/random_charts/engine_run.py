"""Synthesize charts by the public path, and run what comes of them on flexbe_core."""

from __future__ import annotations

import importlib
import itertools
import os
import sys
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from unittest import mock

import rospy
from scripted_states import script

from flexbe_core.engine.engine import Engine, ErrorPolicy
from flexbe_core.engine.supervision import UNSUPERVISED, Ended
from flexbe_core.engine.user_data import BehaviorFailure
from flexbe_core.ros.session import own_session
from flexbe_synthesizer.core.chart.problem import Problem, errors_in
from flexbe_synthesizer.core.library.signature import Library
from flexbe_synthesizer.edge.output_package import output_package
from flexbe_synthesizer.edge.package_path import find_packages, read_library
from flexbe_synthesizer.synthesis import check_files, write_behaviors
from random_charts.reference import ROUND_S

PACKAGES = Path(__file__).parent / "packages"
SRC = Path(__file__).parents[3]
LIBRARY_PATH = (PACKAGES, SRC / "flexbe" / "flexbe_states", SRC / "remodel_states")
_folders = itertools.count()


@cache
def library() -> Library:
    """Return the states that random charts can name."""
    packages, warnings = find_packages(os.pathsep.join(map(str, LIBRARY_PATH)))
    found, more = read_library(packages)
    if warnings or more:
        raise AssertionError((*warnings, *more))
    return found


class Synthesis:
    """Charts of one file and those that it names, checked and, without errors, written.

    Attributes:
        errors: what the checker refuses.
    """

    def __init__(self, files: Mapping[str, bytes], path: str, folder: Path) -> None:
        """Synthesize the chart `path` of the files into a new package in the folder."""
        name = f"random_behaviors_{next(_folders)}"
        self._package = output_package(folder / name)
        checked = check_files([path], library(), lambda _path: self._package, drafts=files)
        self.errors: tuple[Problem, ...] = errors_in(checked.problems)
        self._machine = checked.charts[path].resolved.chart.name if path in checked.charts else ""
        self._created = None
        if not self.errors:
            with mock.patch("os.fsync"):  # a test survives no power failure
                self.written = write_behaviors(checked)

    def text(self) -> str:
        """Return the behavior's file."""
        return self._package.code_path(self._machine).read_text()

    def behavior(self):
        """Return a new object of the behavior's class."""
        if self._created is None:
            folder = str(self._package.folder / "src")
            sys.path.insert(0, folder)
            importlib.invalidate_caches()
            try:
                with mock.patch("sys.dont_write_bytecode", True):
                    module = f"{self._package.name}.{self._package.code_path(self._machine).stem}"
                    found = vars(importlib.import_module(module))
            finally:
                sys.path.remove(folder)
                for loaded in [m for m in sys.modules if m.split(".")[0] == self._package.name]:
                    del sys.modules[loaded]
            (self._created,) = [
                value
                for name, value in found.items()
                if getattr(value, "__module__", "") == module and name.endswith("SM")
            ]
        return self._created()


class EngineRun:
    """One run on the engine; the attributes are those of Reference."""

    def __init__(self, behavior, followed: script.Script, given: Mapping[str, object]) -> None:
        """Prepare to run a behavior."""
        script.start(followed)
        behavior.set_up(1, UNSUPERVISED, False, ErrorPolicy.FAIL)
        behavior.prepare_for_execution(given)
        self._root = behavior._state_machine
        self._engine: Engine = own_session(self._root).engine
        self._engine.recording = True
        self.ended: list[tuple[int, str, str]] = []
        self.outcome: str | None = None
        self.missing: str | None = None

    def order(self, path: str, ids: Iterable[str]) -> list[str]:
        """Return the ids in the order in which the engine executes them in a round."""
        container = self._root
        for label in path.split("/")[1:]:
            container = container[label]
        return [label for label in container if label in ids]

    @property
    def outputs(self) -> Mapping[str, object]:
        """Return the root's outputs."""
        data = self._engine.root.userdata._data
        return {key: data.get(key) for key in self._root.output_keys}

    def run(self, most_rounds: int) -> None:
        """Run until the behavior ends."""
        self._engine.begin()
        time = rospy.rostime
        before = time._rostime_initialized, time._rostime_current
        time.set_rostime_initialized(True)
        try:
            for number in range(most_rounds):
                now = number * ROUND_S
                time._rostime_current = rospy.Time.from_sec(now)
                self.outcome = self._engine.run(now)
                facts = self._engine.take_events()
                self.ended += [(number, f.path, f.outcome) for f in facts if isinstance(f, Ended)]
                if self.outcome is not None:
                    return
        except BehaviorFailure as error:
            self.missing = str(error)
        finally:
            time._rostime_initialized, time._rostime_current = before
