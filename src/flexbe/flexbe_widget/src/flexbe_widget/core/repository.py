"""The files of a repository for behaviors and states of a user's own."""

from __future__ import annotations

import re

_PACKAGE = """\
<?xml version="1.0"?>
<package format="3">
  <name>{name}</name>
  <version>0.0.1</version>
  <description>{description}</description>
  <maintainer email="you@example.com">you</maintainer>
  <license>BSD-3-Clause</license>

  <buildtool_depend>catkin</buildtool_depend>
  <buildtool_depend>python3-setuptools</buildtool_depend>
  <exec_depend>flexbe_core</exec_depend>
  <exec_depend>{depend}</exec_depend>

  <export>
    <{export}/>
  </export>
</package>
"""

_CMAKE = """\
cmake_minimum_required(VERSION 3.10)
project({name})

find_package(catkin REQUIRED)
catkin_python_setup()
catkin_package()
install(DIRECTORY {folder} DESTINATION ${{CATKIN_PACKAGE_SHARE_DESTINATION}})
"""

_SETUP = """\
from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(**generate_distutils_setup(packages=["{name}"], package_dir={{"": "src"}}))
"""

_STATE = '''\
from flexbe_core import EventState, Logger


class ExampleState(EventState):
    """
    Counts how often it is executed, as an example for states of your own.

    -- rounds    int     How often it is executed before it is done.

    #> count     int     How often it was executed.

    <= done              It has been executed often enough.
    """

    def __init__(self, rounds):
        super().__init__(outcomes=["done"], output_keys=["count"])
        self._rounds = rounds
        self._count = 0

    def on_enter(self, userdata):
        self._count = 0

    def execute(self, userdata):
        self._count += 1
        if self._count >= self._rounds:
            userdata.count = self._count
            Logger.loginfo("executed %d times" % self._count)
            return "done"
        return None
'''

_CASE = """\
path: {name}.example_state
class: ExampleState
params: {{rounds: 3}}
output: {{count: 3}}
outcome: done
"""


class RepositoryError(Exception):
    """A repository that cannot be made."""


def repository(name: str) -> dict[str, str]:
    """Return the files, by their paths: a package of behaviors and one of states.

    Raises:
        RepositoryError: if no packages can have this name.
    """
    if not re.fullmatch("[a-z][a-z0-9_]*", name):
        raise RepositoryError(
            f"{name!r} cannot be the name of packages; write lower case letters, digits and _"
        )
    states, behaviors = f"{name}_flexbe_states", f"{name}_flexbe_behaviors"
    top = f"{name}_behaviors"
    return {
        **_package(
            top, states, f"States of {name}.", "flexbe_msgs", export="flexbe_states", folder="tests"
        ),
        f"{top}/{states}/src/{states}/example_state.py": _STATE,
        f"{top}/{states}/tests/example.test": _CASE.format(name=states),
        **_package(
            top,
            behaviors,
            f"Behaviors of {name}.",
            states,
            export="flexbe_behaviors",
            folder="manifest",
        ),
        f"{top}/{behaviors}/manifest/.gitkeep": "",
    }


def _package(
    top: str, name: str, description: str, depend: str, export: str, folder: str
) -> dict[str, str]:
    root = f"{top}/{name}"
    return {
        f"{root}/package.xml": _PACKAGE.format(
            name=name, description=description, depend=depend, export=export
        ),
        f"{root}/CMakeLists.txt": _CMAKE.format(name=name, folder=folder),
        f"{root}/setup.py": _SETUP.format(name=name),
        f"{root}/src/{name}/__init__.py": "",
    }
