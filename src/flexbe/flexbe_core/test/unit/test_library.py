"""The behavior library: what it finds, and what does not stop it."""

import textwrap
from threading import Event, Thread

import pytest

from flexbe_core import BehaviorLibrary
from flexbe_core.behavior_library import ManifestError, read_manifest, source_file
from flexbe_core.engine.supervision import checksum

PACKAGE = "<package format='3'><name>{name}</name><export><flexbe_behaviors/></export></package>"
MANIFEST = "<behavior name='{name}'><executable package_path='{path}' class='C'/></behavior>"


@pytest.fixture
def workspace(tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    return tmp_path


@pytest.fixture
def warnings(monkeypatch):
    warned = []
    monkeypatch.setattr("rospy.logwarn", lambda form, *args: warned.append(form % args))
    return warned


def write(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(textwrap.dedent(text))


def add_package(workspace, name, behaviors):
    write(workspace / name / "package.xml", PACKAGE.format(name=name))
    for behavior, module in behaviors.items():
        text = MANIFEST.format(name=behavior, path=f"{name}.{module}")
        write(workspace / name / "manifest" / f"{module}.xml", text)
        write(workspace / name / "src" / name / f"{module}.py", "")


def test_behaviors_are_found_by_name_and_id(workspace):
    add_package(workspace, "cell", {"Wire It": "wire_it_sm"})
    library = BehaviorLibrary()
    behavior_id, entry = library.find_behavior("Wire It")
    assert behavior_id == checksum("cell.wire_it_sm")
    assert entry == {"name": "Wire It", "package": "cell", "file": "wire_it_sm", "class": "C"}
    assert library.get_behavior(behavior_id) is entry
    assert library.count_behaviors() == 1
    assert library.get_sourcecode_filepath(behavior_id) == str(
        workspace / "cell" / "src" / "cell" / "wire_it_sm.py"
    )
    assert library.get_sourcecode_filepath(behavior_id, add_tmp=True).endswith("/wire_it_sm_tmp.py")


def test_of_two_manifests_of_one_behavior_the_last_names_it(workspace):
    add_package(workspace, "cell", {"Wire It": "wire_it_sm"})
    other = MANIFEST.format(name="Tie It", path="cell.wire_it_sm")
    write(workspace / "cell" / "manifest" / "zz.xml", other)
    library = BehaviorLibrary()
    assert library.find_behavior("Wire It") == (None, None)
    behavior_id, entry = library.find_behavior("Tie It")
    assert (behavior_id, entry["name"]) == (checksum("cell.wire_it_sm"), "Tie It")


def test_a_behavior_is_found_while_another_thread_reads_the_packages_again(workspace):
    add_package(workspace, "cell", {})
    library, found, has_read, may_go_on = BehaviorLibrary(), [], Event(), Event()
    add_package(workspace, "cell", {"First": "first_sm"})
    read = library._read_manifests

    def read_first(*words):
        read(*words)
        has_read.set()
        may_go_on.wait(0.5)

    def read_second(*words):
        may_go_on.set()
        thread.join()
        read(*words)

    library._read_manifests = read_first
    thread = Thread(target=lambda: found.append(library.find_behavior("First")[0]))
    thread.start()
    has_read.wait()
    library._read_manifests = read_second
    library.find_behavior("Missing")
    assert found == [checksum("cell.first_sm")]


def test_what_does_not_exist_is_none(workspace):
    library = BehaviorLibrary()
    assert library.find_behavior("Nothing") == (None, None)
    assert library.get_behavior(5) is None
    assert library.get_sourcecode_filepath(5) is None


def test_manifests_and_packages_that_come_later_are_found(workspace):
    add_package(workspace, "cell", {"First": "first_sm"})
    library = BehaviorLibrary()
    add_package(workspace, "cell", {"Second": "second_sm"})
    assert library.find_behavior("Second")[0] is not None
    add_package(workspace, "later", {"Third": "third_sm"})
    assert library.find_behavior("Third")[0] is not None
    assert library.names() == ("First", "Second", "Third")


def test_a_manifest_that_changed_is_read_again(workspace):
    add_package(workspace, "cell", {"First": "first_sm"})
    library = BehaviorLibrary()
    path = workspace / "cell" / "manifest" / "first_sm.xml"
    path.write_text(path.read_text().replace("class='C'", "class='D'"))
    assert library.find_behavior("First")[1]["class"] == "D"
    path.unlink()
    assert library.find_behavior("First") == (None, None)


BROKEN = {
    "no XML": "<behavior",
    "no executable": "<behavior name='x'/>",
    "no name": MANIFEST.format(name="", path="cell.x_sm"),
    "one component": MANIFEST.format(name="x", path="cell"),
    "a file name": MANIFEST.format(name="x", path="cell.x_sm.py/../y"),
    "nothing at all": "",
    "an unknown encoding": "<?xml version='1.0' encoding='none'?><behavior name='x'/>",
    "an encoding that cannot be read": "<?xml version='1.0' encoding='big5'?><behavior name='x'/>",
}


@pytest.mark.parametrize("text", BROKEN.values(), ids=BROKEN)
def test_a_broken_manifest_costs_one_warning(workspace, warnings, text):
    add_package(workspace, "cell", {"Good": "good_sm"})
    write(workspace / "cell" / "manifest" / "broken.xml", text)
    assert BehaviorLibrary().names() == ("Good",)
    assert len(warnings) == 1
    assert "broken.xml is left out: it " in warnings[0]


def test_other_files_of_a_package_cost_nothing(workspace, warnings):
    add_package(workspace, "cell", {"Good": "good_sm"})
    write(workspace / "cell" / "charts" / "chart.xml", "<statemachine name='x'/>")
    write(workspace / "cell" / "manifest" / "#good_sm.xml", "<beh")
    write(workspace / "cell" / "manifest" / "other.xml", MANIFEST.format(name="x", path="other.x"))
    assert BehaviorLibrary().names() == ("Good",)
    assert warnings == []


def test_a_broken_package_anywhere_costs_one_warning_each(workspace, warnings):
    add_package(workspace, "cell", {"Good": "good_sm"})
    write(workspace / "broken" / "package.xml", "<package><export><flexbe_behaviors/>")
    write(workspace / "unconcerned" / "package.xml", "<package><name>")
    write(
        workspace / "encoded" / "package.xml",
        "<?xml version='1.0' encoding='a'?><flexbe_behaviors/>",
    )
    assert BehaviorLibrary().names() == ("Good",)
    assert len(warnings) == 2


def test_of_two_behaviors_with_one_name_the_first_is_used(workspace, warnings):
    add_package(workspace, "a", {"Same": "same_sm"})
    add_package(workspace, "b", {"Same": "same_sm"})
    assert BehaviorLibrary().find_behavior("Same")[1]["package"] == "a"
    assert "there are two behaviors named 'Same'" in warnings[0]


def test_warnings_are_logged_once(workspace, warnings):
    add_package(workspace, "cell", {"Good": "good_sm"})
    write(workspace / "cell" / "manifest" / "broken.xml", "<beh")
    library = BehaviorLibrary()
    library.find_behavior("Nothing")
    assert len(warnings) == 1


def test_a_package_inside_a_folder_that_is_no_part_of_the_workspace_is_ignored(workspace):
    add_package(workspace, "cell", {"Good": "good_sm"})
    add_package(workspace / "backup", "old", {"Old": "old_sm"})
    write(workspace / "backup" / "CATKIN_IGNORE", "")
    assert BehaviorLibrary().names() == ("Good",)


def test_installed_packages_have_their_modules_on_the_python_path(tmp_path, monkeypatch):
    write(tmp_path / "lib" / "cell" / "sub" / "wire_sm.py", "")
    monkeypatch.syspath_prepend(str(tmp_path / "lib"))
    found = source_file("cell", "cell.sub.wire_sm", tmp_path / "share" / "cell")
    assert found == tmp_path / "lib" / "cell" / "sub" / "wire_sm.py"


def test_other_xml_is_no_manifest():
    assert read_manifest(b"<statemachine name='x'/>") is None
    with pytest.raises(ManifestError, match="no <executable"):
        read_manifest(
            b"<behavior name='x'><group><executable package_path='a.b'/></group></behavior>"
        )
