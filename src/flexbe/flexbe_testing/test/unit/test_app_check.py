"""The command that reports what the FlexBE App would lose."""

import pytest

from flexbe_testing.app_check import FINE, LOSSES, USAGE, main

PACKAGE = """<package format="3"><name>my_cell</name><version>0.0.1</version>
<description>d</description><maintainer email="a@b.cd">a</maintainer><license>BSD</license>
<export><flexbe_states/><flexbe_behaviors/></export></package>"""
STATE = """class MoveState(EventState):
    def __init__(self, speed):
        super().__init__(outcomes=["done"])
"""
BEHAVIOR = """\
from flexbe_core import Behavior, Autonomy, OperatableStateMachine, ConcurrencyContainer, \
PriorityContainer, Logger
from my_cell.move_state import MoveState

'''
Created on today
@author: Somebody
'''
class MoveTwiceSM(Behavior):
    '''
    Moves.
    '''

    def __init__(self):
        super(MoveTwiceSM, self).__init__()
        self.name = 'Move Twice'
        # Behavior comments:

    def create(self):
        # x:500 y:40
        _state_machine = OperatableStateMachine(outcomes=['done'])

        with _state_machine:
            # x:30 y:40
            OperatableStateMachine.add('Move', MoveState(speed=1),
                                        transitions={'done': 'done'},
                                        autonomy={'done': Autonomy.Off})
        return _state_machine
"""
MANIFEST = """<behavior name="Move Twice">
<executable package_path="my_cell.move_twice_sm" class="MoveTwiceSM"/>
<author>Somebody</author><description>Moves.</description></behavior>"""


@pytest.fixture
def package(tmp_path, monkeypatch):
    folder = tmp_path / "my_cell"
    files = {
        "package.xml": PACKAGE,
        "manifest/move_twice.xml": MANIFEST,
        "src/my_cell/move_state.py": STATE,
        "src/my_cell/move_twice_sm.py": BEHAVIOR,
    }
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    return folder


def test_a_package_that_the_app_keeps_whole(package, capsys):
    assert main(["my_cell"]) == FINE
    assert capsys.readouterr().out == ""


def test_what_is_lost_is_reported_with_its_file(package, capsys):
    (package / "src/my_cell/move_state.py").write_text(STATE.replace("(self, ", "(\n  self, "))
    assert main([str(package)]) == LOSSES
    assert capsys.readouterr().out.splitlines() == [
        f"{package}/src/my_cell/move_state.py: line 2: the App does not see the arguments speed of "
        "MoveState: all must follow 'def __init__(self, ' on one line, without annotations "
        "and inner ')'",
        f"{package}/src/my_cell/move_twice_sm.py: the App loses parameter speed of '/Move', which "
        "MoveState hides",
    ]


def test_what_is_wrong_with_a_manifest_is_reported(package, capsys):
    (package / "manifest/move_twice.xml").write_text(MANIFEST.replace("Somebody", ""))
    assert main(["my_cell"]) == LOSSES
    assert "manifest/move_twice.xml: the behavior has no author" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("file", "text", "complaint"),
    [
        ("manifest/move_twice.xml", "<behavior", "move_twice.xml is not XML"),
        ("src/my_cell/move_state.py", "class", "move_state.py:1: not Python 3: invalid syntax"),
        ("src/my_cell/move_state.py", "\udcff", "move_state.py is not UTF-8"),
        (None, "", "there is no ROS package 'nothing'"),
    ],
)
def test_what_cannot_be_read_is_a_usage_error(file, text, complaint, package, capsys):
    if file is not None:
        (package / file).write_text(text, errors="surrogateescape")
    assert main(["my_cell" if file else "nothing"]) == USAGE
    assert complaint in capsys.readouterr().err
