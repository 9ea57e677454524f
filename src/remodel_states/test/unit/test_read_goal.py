"""What the conformance command is given: an action, and a goal of it."""

import pytest
from remodel_msgs.msg import DetectCableAction

from remodel_states.conformance.probe import GoalError, action_class


@pytest.mark.parametrize("name", ["DetectCable", "DetectCableAction", "remodel_msgs/DetectCable"])
def test_an_action_has_several_names(name):
    assert action_class(name) is DetectCableAction


@pytest.mark.parametrize(
    "name", ["a/b/c", "/x", "x/", "", "std_msgs/String", "no_such_package/Grasp", "DetectCables"]
)
def test_what_is_no_action_is_refused(name):
    with pytest.raises(GoalError, match=r"no action|cannot load"):
        action_class(name)


@pytest.mark.parametrize(
    ("source", "found"),
    [("raise RuntimeError('no drivers')", "RuntimeError: no drivers"), ("class (", "SyntaxError")],
)
def test_a_package_that_cannot_be_imported_is_named(tmp_path, monkeypatch, source, found):
    package = f"broken_{found.partition(':')[0].lower()}"
    (tmp_path / package / "msg").mkdir(parents=True)
    (tmp_path / package / "__init__.py").write_text("")
    (tmp_path / package / "msg/__init__.py").write_text(source)
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(GoalError, match=f"cannot load {package}/GraspAction: {found}"):
        action_class(f"{package}/Grasp")
