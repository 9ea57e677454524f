"""docs/production-database.md shows the tables that there are."""

import importlib.util
import subprocess
from pathlib import Path

ROOT = Path(__file__).parents[4]
SPEC = importlib.util.spec_from_file_location("draw_database", ROOT / "tools/draw_database.py")
draw_database = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(draw_database)


def test_the_page_has_the_tables_of_the_models():
    text = draw_database.PAGE.read_text(encoding="utf-8")
    drawn = text.partition(draw_database.BEGIN)[2].partition(draw_database.END)[0]
    assert drawn == draw_database.drawn()


def test_the_picture_was_drawn_from_the_models():
    assert draw_database.PICTURE.read_text(encoding="utf-8").endswith(draw_database.digest())


def test_the_picture_can_be_drawn():
    drawn = subprocess.run(
        ["dot", "-Tsvg"], input=draw_database.graph(), capture_output=True, text=True, timeout=60
    )
    assert drawn.returncode == 0, drawn.stderr
    assert drawn.stderr == ""
    assert all(f">{table.name}<" in drawn.stdout for table in draw_database.tables())
