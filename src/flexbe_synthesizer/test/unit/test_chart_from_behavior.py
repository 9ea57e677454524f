from flexbe_synthesizer.chart_from_behavior import FINE, INEXPRESSIBLE, USAGE, main
from flexbe_synthesizer.core.chart.chart_reader import parse_chart


def test_a_behavior_is_written_as_a_chart_to_the_screen_or_a_file(
    golden, package_path, tmp_path, capsys
):
    behavior = golden / "behaviors" / "place_connector_sm.py"
    assert main([str(behavior)], package_path) == FINE
    text = capsys.readouterr().out
    assert parse_chart(text).name == "Place Connector"
    marked = tmp_path / "marked_sm.py"
    marked.write_bytes(b"\xef\xbb\xbf" + behavior.read_bytes())  # as some editors save it
    chart = tmp_path / "charts" / "chart.xml"
    assert main([str(marked), "--output", str(chart)], package_path) == FINE
    assert chart.read_text() == text


def test_what_cannot_be_read_is_reported_with_its_place(golden, package_path, tmp_path, capsys):
    own = tmp_path / "own_sm.py"
    text = (golden / "behaviors" / "place_connector_sm.py").read_text()
    own.write_text(text.replace("        return _s", "        print()\n        return _s"))
    assert main([str(own)], package_path) == INEXPRESSIBLE
    assert capsys.readouterr().err.startswith(f"{own}:")
    own.write_bytes(b"\xa7")
    for path in (own, tmp_path, tmp_path / "none_sm.py"):
        assert main([str(path)], package_path) == USAGE
        assert f"{path} cannot be read" in capsys.readouterr().err
