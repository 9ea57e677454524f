import os
import shutil
from itertools import count

import pytest

from flexbe_synthesizer.edge.package_path import find_packages, read_inventory, read_library

_STATES, _BEHAVIORS = "cell_states", "cell_behaviors"
_STATE = f"{_STATES}/src/cell_states/pause_state.py"
_FAULTS = f"{_STATES}/config/faults.yaml"
_AGES = count(1)


@pytest.fixture
def packages(tmp_path, package_path):
    return shutil.copytree(package_path, tmp_path / "packages")


def let_rest(top):
    """Date all files and folders back to an hour at which nothing else was written."""
    hour = 3600 * next(_AGES)
    for folder, inner, files in os.walk(top):
        for name in (*inner, *files, "."):
            path = os.path.join(folder, name)
            os.utime(path, (hour, hour))


def replaced(path, old, new):
    def change(top):
        file = top / path
        file.write_text(file.read_text().replace(old, new))

    return change


change_a_state = replaced(_STATE, "PauseState", "HaltStates")  # as many letters


def swap_a_state(top):
    """Put another file in its place that has the same size and time."""
    file = top / _STATE
    before = file.stat()
    new = file.with_suffix(".new")
    new.write_text(file.read_text().replace("PauseState", "RestStates"))
    os.utime(new, ns=(before.st_mtime_ns, before.st_mtime_ns))
    new.replace(file)


def add_a_state_in_a_folder(top):
    (top / "cell_states/src/cell_states/more/deep").mkdir(parents=True)
    text = (top / _STATE).read_text().replace("PauseState", "DeepState")
    (top / "cell_states/src/cell_states/more/deep/deep_state.py").write_text(text)


def add_a_package(top):
    shutil.copytree(top / "cell_states", top / "nested" / "deeper" / "new_states")
    xml = top / "nested" / "deeper" / "new_states" / "package.xml"
    xml.write_text(xml.read_text().replace("cell_states", "new_states"))
    source = xml.parent / "src"
    (source / "cell_states").rename(source / "new_states")


def make_a_state_a_pipe(top):
    (top / _STATE).unlink()
    os.mkfifo(top / _STATE)


_CHANGES = {
    "change a state": change_a_state,
    "swap a state": swap_a_state,
    "add a state in a folder": add_a_state_in_a_folder,
    "add a package": add_a_package,
    "rename a behavior": replaced(f"{_BEHAVIORS}/manifest/clean_up.xml", "Clean Up", "Tidy Up!"),
    "change the code of a behavior": replaced(
        f"{_BEHAVIORS}/src/cell_behaviors/clean_up_sm.py", "'failed'", "'broken'"
    ),
    "stop exporting states": replaced(f"{_STATES}/package.xml", "flexbe_states", "flexbe_other"),
    "hide a package": lambda top: (top / _STATES / "CATKIN_IGNORE").touch(),
    "delete a package": lambda top: shutil.rmtree(top / _STATES),
    "break a state": lambda top: (top / _STATE).write_text("class (EventState):"),
    "make a state a pipe": make_a_state_a_pipe,
    "change an error code": replaced(_FAULTS, "301", "302"),
    "break the error codes": lambda top: (top / _FAULTS).write_text("faults: [1, name: JAMMED}"),
}


def test_what_has_not_changed_is_not_read_again(packages):
    let_rest(packages)
    assert read_inventory(str(packages)) is read_inventory(str(packages))


def test_a_second_change_within_one_tick_of_the_clock_is_seen(packages):
    file = packages / _STATE
    os.utime(file)
    before = file.stat()
    first = read_inventory(str(packages))
    change_a_state(packages)
    os.utime(file, ns=(before.st_mtime_ns, before.st_mtime_ns))
    assert read_inventory(str(packages)) != first


@pytest.mark.parametrize("change", _CHANGES.values(), ids=_CHANGES)
def test_a_change_is_seen_at_once(packages, change):
    let_rest(packages)
    before = read_inventory(str(packages))
    change(packages)
    now = read_inventory(str(packages))
    assert now != before
    found, path_warnings = find_packages(str(packages))
    library, warnings = read_library(found)
    assert (now.packages, now.library) == (found, library)
    assert now.warnings == (*path_warnings, *warnings)
    let_rest(packages)
    assert read_inventory(str(packages)) == now
    assert read_inventory(str(packages)) is read_inventory(str(packages))


_NAMED = "<package><name>{}</name><export><flexbe_states/><flexbe_behaviors/></export></package>"


@pytest.mark.parametrize(
    ("file", "text", "warning"),
    [
        ("package.xml", '<?xml version="1.0" encoding="x"?><package/>', "unknown encoding: x"),
        ("package.xml", _NAMED.format("a.b"), "names no package: 'a.b'"),
        ("package.xml", _NAMED.format("__main__"), "names no package: '__main__'"),
        ("package.xml", _NAMED.format(""), "names no package: ''"),
        ("config/faults.yaml", "[" * 3000, "its error codes are left out"),
        ("config/faults.yaml", "faults: [{codes: 301}]", "'codes' is 301; allowed: a list"),
        (
            "src/cell_states/pause_state.py",
            f"x = {'-' * 100_000}1  # (EventState)",
            "nested too deeply; its state is left out",
        ),
    ],
)
def test_a_file_that_cannot_be_read_costs_a_warning_and_nothing_else(packages, file, text, warning):
    (packages / _STATES / file).write_text(text)
    found = read_inventory(str(packages))
    assert warning in "\n".join(found.warnings)
    assert "flexbe_states" in {package.name for package in found.packages}


def test_links_in_circles_end(tmp_path, packages):
    for name in ("back", "again"):
        (packages / name).symlink_to(packages)
        (packages / f"round_{name}").symlink_to(tmp_path)
    lost = tmp_path / "lost"
    lost.symlink_to(lost)
    found = read_inventory(f"{lost}:{packages}")
    assert found.packages
    assert not found.warnings


def test_a_package_that_appears_on_the_path_is_seen(tmp_path, package_path):
    late = tmp_path / "late"
    assert not read_inventory(str(late)).packages
    shutil.copytree(package_path, late)
    assert read_inventory(str(late)).packages


def test_an_installed_package_is_read_again_when_its_python_package_changes(
    tmp_path, monkeypatch, package_path
):
    source = f"{package_path}/cell_states"
    share = shutil.copytree(source, tmp_path / "share" / "cell_states")
    shutil.rmtree(share / "src")
    code = shutil.copytree(f"{source}/src/cell_states", tmp_path / "lib" / "cell_states")
    monkeypatch.syspath_prepend(str(tmp_path / "lib"))
    let_rest(tmp_path)
    path = str(tmp_path / "share")
    assert read_inventory(path) is read_inventory(path)
    (code / "pause_state.py").unlink()
    modules = [state.module for state in read_inventory(path).library.states]
    assert "cell_states.locate_component_state" in modules
    assert "cell_states.pause_state" not in modules
