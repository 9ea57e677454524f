"""A behavior of 200 states: ten containers of twenty, one after the other, again and again."""

from flexbe_synthesizer.core.chart.model import Chart, Container, Outcome, Param, State, Transition

BOXES, STATES = 10, 20


def large_chart(name, visit_s):
    """Return the chart; each state is left after a time [s]."""
    boxes = tuple(_box(number, visit_s) for number in range(BOXES))
    return Chart(name, "Box 0", (Outcome("finished"),), boxes)


def _box(number, visit_s):
    ids = [f"S{number}_{place}" for place in range(STATES)]
    nodes = tuple(
        State(
            one,
            "WaitState",
            (Transition("done", following),),
            params=(Param("wait_time", visit_s),),
        )
        for one, following in zip(ids, (*ids[1:], "through"), strict=True)
    )
    body = Chart(f"Box {number}", ids[0], (Outcome("through"),), nodes)
    led = (Transition("through", f"Box {(number + 1) % BOXES}"),)
    if number:
        return Container(f"Box {number}", "container", led, body=body)
    led = (*led, Transition("exhausted", "finished"))
    return Container("Box 0", "container", led, attempts=100000, body=body)
