"""Behaviors are found by their manifests, in packages that may appear while a run is under way."""

import pytest

from remodel_supervision.edge.known_behaviors import describes

PACKAGE = """<package><name>{name}</name><version>1.0.0</version><description>d</description>
<maintainer email="a@b.de">a</maintainer><license>BSD-3-Clause</license>
<export>{export}</export></package>"""
MANIFEST = """<behavior name="{name}"><description>{text}</description></behavior>"""


@pytest.fixture
def roots(tmp_path, monkeypatch):
    roots = tmp_path / "workspace", tmp_path / "made" / "task_behaviors"
    roots[0].mkdir()
    monkeypatch.setenv("ROS_PACKAGE_PATH", ":".join(map(str, roots)))
    monkeypatch.delenv("ROS_ROOT", raising=False)
    return roots


def add_package(folder, export="<flexbe_behaviors/>"):
    (folder / "manifest").mkdir(parents=True)
    (folder / "package.xml").write_text(PACKAGE.format(name=folder.name, export=export))


def add_behavior(folder, file, name, text):
    (folder / "manifest" / file).write_text(MANIFEST.format(name=name, text=text))


def test_a_behavior_is_known_with_its_present_description(roots):
    package = roots[0] / "shipped"
    add_package(package)
    assert not describes("Wire W-1", "Content ab.")
    add_behavior(package, "wire_w_1.xml", "Wire W-1", "Wires. Content ab.")
    assert describes("Wire W-1", "Content ab.")
    assert not describes("Wire W 1", "Content ab."), "another behavior under the same file name"
    add_behavior(package, "wire_w_1.xml", "Wire W-1", "Wires. Content cd.")
    assert not describes("Wire W-1", "Content ab.")
    (package / "manifest" / "wire_w_1.xml").write_text("<behav")
    assert not describes("Wire W-1", "Content cd."), "half written"


def test_a_package_that_appears_later_is_found(roots):
    add_package(roots[0] / "others", export="")
    add_behavior(roots[0] / "others", "wire_w1.xml", "Wire W1", "Content ab.")
    assert not describes("Wire W1", "Content ab."), "the package exports no behaviors"
    add_package(roots[1])
    add_behavior(roots[1], "wire_w1.xml", "Wire W1", "Content ab.")
    assert describes("Wire W1", "Content ab.")
    add_package(roots[0] / "new")
    add_behavior(roots[0] / "new", "wire_w2.xml", "Wire W2", "Content ef.")
    assert describes("Wire W2", "Content ef.")
