"""From a name to a class: which sources are run, and which are not."""

import sys
import types

import pytest

from flexbe_core import BehaviorLibrary
from flexbe_core.engine.supervision import checksum
from flexbe_onboard.behavior_source import Modification, ModuleFreshness, StartError, load_behavior

SOURCE = """\
from flexbe_core import Behavior

class AHelper:
    pass

class WireSM(Behavior):
    text = "first"
"""


@pytest.fixture
def package(tmp_path, monkeypatch):
    """Return the folder of the modules of a package `cell` with a behavior."""
    folder = tmp_path / "cell"
    source = folder / "src" / "cell"
    source.mkdir(parents=True)
    (folder / "package.xml").write_text(
        "<package><name>cell</name><export><flexbe_behaviors/></export></package>"
    )
    (folder / "wire.xml").write_text(
        "<behavior name='Wire'><executable package_path='cell.wire_sm' class='WireSM'/></behavior>"
    )
    (source / "__init__.py").write_text("")
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.setattr(sys, "modules", {**sys.modules})
    return source


def load(package, text=SOURCE, wanted=None, modifications=()):
    (package / "wire_sm.py").write_text(text)
    wanted = checksum(text) if wanted is None else wanted
    return load_behavior(BehaviorLibrary(), checksum("cell.wire_sm"), wanted, modifications)


def test_the_class_of_the_manifest_is_taken_not_the_first_of_the_module(package):
    assert load(package).__name__ == "WireSM"


def test_another_class_is_taken_if_it_is_the_only_behavior(package):
    assert load(package, SOURCE.replace("WireSM", "OtherSM")).__name__ == "OtherSM"


def test_a_module_without_a_behavior_is_refused(package):
    with pytest.raises(StartError, match="has no class 'WireSM' that is a Behavior; it has: none"):
        load(package, "class WireSM:\n    pass\n")


def test_another_checksum_is_refused_with_both(package):
    with pytest.raises(StartError, match=f"has checksum {checksum(SOURCE)}, the request has 17"):
        load(package, wanted=17)


def test_a_source_that_does_not_compile_is_refused_with_its_place(package):
    with pytest.raises(StartError, match=r"SyntaxError: .*wire_sm.py, line 1"):
        load(package, "def\n")


@pytest.mark.parametrize(
    "line", ["raise ValueError('no')", "import sys; sys.exit(1)", "import nosuchmodule"]
)
def test_a_source_that_fails_on_import_is_refused(package, line):
    with pytest.raises(StartError, match="cannot import"):
        load(package, line)


def test_an_unknown_behavior_names_the_known_ones(package):
    with pytest.raises(StartError, match="no behavior with id 3 on this computer; there are: Wire"):
        load_behavior(BehaviorLibrary(), 3, 0)


def test_a_manifest_without_a_source_is_refused(package):
    with pytest.raises(StartError, match=r"found no file for cell.wire_sm"):
        load_behavior(BehaviorLibrary(), checksum("cell.wire_sm"), 0)


def test_modifications_are_applied_and_leave_the_installed_module_alone(package):
    begin = SOURCE.index("first")
    change = Modification(begin, begin + len("first"), "other")
    modified = load(
        package, wanted=checksum(SOURCE.replace("first", "other")), modifications=[change]
    )
    assert modified.text == "other"
    assert load(package).text == "first"


def test_contained_modules_are_read_again_when_they_changed(package):
    (package / "part.py").write_text("TEXT = 'first'\n")
    source = SOURCE.replace('"first"', "TEXT").replace(
        "\n\n", "\nfrom cell.part import TEXT\n\n", 1
    )
    freshness = ModuleFreshness()
    assert load(package, source).text == "first"
    freshness.remember()
    (package / "part.py").write_text("TEXT = 'other'\n")  # as long, and within the same second
    assert load(package, source).text == "first"
    freshness.forget_changed()
    assert load(package, source).text == "other"


def test_modules_stay_while_nothing_changed(package):
    (package / "part.py").write_text("TEXT = 'first'\n")
    source = SOURCE + "\nimport cell.part\n"
    freshness = ModuleFreshness()
    load(package, source)
    freshness.remember()
    part = sys.modules["cell.part"]
    freshness.forget_changed()
    load(package, source)
    assert sys.modules["cell.part"] is part
    freshness.forget_all()
    assert "cell.part" not in sys.modules


def test_a_lazy_module_is_left_alone(monkeypatch):
    class Lazy(types.ModuleType):
        def __getattr__(self, name):
            raise ImportError("what it stands for is not installed")

    freshness = ModuleFreshness()
    monkeypatch.setitem(sys.modules, "lazy_module", Lazy("lazy_module"))
    freshness.remember()
    assert "lazy_module" not in freshness._stamps
