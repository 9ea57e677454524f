from flexbe_synthesizer.core.chart.chart_reader import parse_chart
from flexbe_synthesizer.core.machine.lower import chart_steps


def test_what_an_engine_reports_is_translated_to_the_words_of_the_chart(golden):
    chart = parse_chart((golden / "charts" / "place_connector.xml").read_bytes())
    taken = [
        ("/Locate_attempts", "counted"),
        ("/Locate", "located"),
        ("/Insert", "inserted"),
        ("/Fix/run", "failed"),
        ("/Fix/timer", "done"),
        ("/Elsewhere", "done"),
        ("/Locate_attempts", "exhausted"),
    ]
    assert chart_steps(chart, taken) == (
        ("Locate", "located"),
        ("Insert", "inserted"),
        ("Fix", "failed"),
        ("Locate", "exhausted"),
    )
