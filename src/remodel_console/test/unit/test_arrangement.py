"""Which parts of a page are shown, and in which order."""

import pytest

from remodel_console.core.settings import PagePart, arranged, arrangement_text, moved, with_shown

PARTS = (
    PagePart("Cell", "middle"),
    PagePart("Figures", "middle"),
    PagePart("Levels", "right"),
    PagePart("Failures", "right"),
)


def titles(parts):
    return [part.title for part in parts]


def test_what_a_browser_kept_is_arranged_again():
    parts = with_shown(moved(PARTS, "Figures", -1), "Failures", is_shown=False)
    assert arranged(PARTS, arrangement_text(parts)) == parts
    assert titles(parts) == ["Figures", "Cell", "Levels", "Failures"]
    assert [part.is_shown for part in parts] == [True, True, True, False]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", ["Cell", "Figures", "Levels", "Failures"]),
        ("Failures,-Levels", ["Failures", "Levels", "Cell", "Figures"]),
        ("-Gone,Levels,,--Cell", ["Levels", "Cell", "Figures", "Failures"]),
    ],
)
def test_parts_that_a_text_does_not_name_follow_and_others_are_left_out(text, expected):
    assert titles(arranged(PARTS, text)) == expected


def test_a_part_moves_only_in_its_column():
    assert moved(PARTS, "Levels", -1) == PARTS
    assert moved(PARTS, "Figures", 1) == PARTS
    assert titles(moved(PARTS, "Levels", 1)) == ["Cell", "Figures", "Failures", "Levels"]
