"""The document about the engine shows the tables that run."""

import importlib.util
from pathlib import Path

ROOT = Path(__file__).parents[5]


def test_the_drawing_in_the_document_is_of_the_tables_as_they_are():
    spec = importlib.util.spec_from_file_location("draw_engine", ROOT / "tools" / "draw_engine.py")
    draw_engine = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(draw_engine)
    text = draw_engine.DOCUMENT.read_text()
    found = text.partition(draw_engine.BEGIN)[2].partition(draw_engine.END)[0]
    assert found == draw_engine.drawn(), "run tools/draw_engine.py"
