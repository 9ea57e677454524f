"""The configuration: its file, and what may stand in it."""

import json
import stat

import pytest

from remodel_console.core.settings import Settings, difference, read_settings, write_settings
from remodel_console.edge.kept_files import SettingsFile
from remodel_console.errors import CommandError

FULL = Settings(
    False,
    "flexbe/synthesize",
    system="cell 1",
    are_commands_allowed=False,
    command_key="secret",
    chart_folders=("/charts",),
    plots=("/joint_states.position[3]", "/cell/wrist/wrench.wrench.force.z"),
)


@pytest.mark.parametrize("settings", [Settings(), FULL])
def test_what_is_written_is_read(settings):
    assert read_settings(write_settings(settings)) == settings


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[]", "no JSON object"),
        ("{", "Expecting"),
        ('{"sytem": "x"}', "unknown: sytem; known: are_commands_allowed"),
        ('{"system": 3}', "system is 3, not a str"),
        ('{"is_synthesis_enabled": 1}', "not a bool"),
        ('{"chart_folders": "x"}', "not a list of paths"),
        ('{"chart_folders": ["charts"]}', "'charts' is no absolute path"),
        ('{"system": "a\\nb"}', "no text of one line"),
        ('{"plots": "x"}', "not a list of fields of topics"),
        ('{"plots": ["/joint_states"]}', "'/joint_states' is no plot; write /TOPIC.FIELD"),
        ('{"plots": ["/a.b", "/a.b"]}', "/a.b is plotted already"),
        (f'{{"plots": {json.dumps([f"/a.b{i}" for i in range(9)])}}}', "at most 8 fields"),
    ],
)
def test_a_wrong_file_is_reported(text, words):
    with pytest.raises(ValueError, match=words.replace("(", r"\(")):
        read_settings(text)


def test_changes_are_logged_but_a_key_is_not():
    words = difference(Settings(), FULL)
    assert "synthesis_topic = 'flexbe/synthesize'" in words
    assert "command_key changed" in words
    assert "secret" not in words
    assert difference(FULL, FULL) == "nothing"


@pytest.fixture
def home(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    folder = tmp_path / "home" / "charts"
    folder.mkdir(parents=True)
    return folder


def test_settings_outlive_a_restart_and_only_their_owner_reads_them(home, tmp_path):
    path = tmp_path / "deep" / "settings.json"
    changes = []
    kept = SettingsFile(path, "")
    kept.on_change = lambda: changes.append(kept.now)
    wanted = Settings(command_key="secret", chart_folders=(str(home),))
    kept.change(lambda _: wanted)
    assert SettingsFile(path, "").now == wanted == changes[0]
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


def test_a_chart_folder_must_exist_and_lie_in_the_home_folder_or_a_package(home, tmp_path):
    kept = SettingsFile(tmp_path / "settings.json", "")
    with pytest.raises(CommandError, match="there is no folder"):
        kept.change(lambda _: Settings(chart_folders=(str(home / "none"),)))
    (home / "out").symlink_to(tmp_path)
    for settings in (Settings(chart_folders=(str(f),)) for f in (tmp_path, home / "out")):
        with pytest.raises(CommandError, match="neither in the home folder nor in a ROS package"):
            kept.change(lambda _, settings=settings: settings)
    assert kept.now == Settings()


def test_a_file_that_is_no_settings_file_is_named(tmp_path):
    path = tmp_path / "settings.json"
    path.write_text("{]")
    with pytest.raises(ValueError, match=r"settings\.json: .*delete it to start with the defaults"):
        SettingsFile(path, "")


def test_settings_that_cannot_be_written_stay_as_they_were(tmp_path):
    (tmp_path / "file").write_text("")
    kept = SettingsFile(tmp_path / "folder.json", "")
    kept._path = tmp_path / "file" / "settings.json"
    with pytest.raises(CommandError, match="cannot be saved"):
        kept.change(lambda _: Settings(system="x"))
    assert kept.now == Settings()
