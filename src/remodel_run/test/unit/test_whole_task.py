"""What is counted as a task."""

from remodel_run.whole_task import whole_tasks


def test_the_cores_of_a_cable_are_one_task_at_the_place_of_the_first():
    found = whole_tasks((("K1", "K"), ("W1", ""), ("K2", "K"), ("W2", "")))
    assert [str(each) for each in found] == ["K (K1 K2)", "W1", "W2"]


def test_one_core_alone_and_wires_named_as_a_cable_are_wires():
    found = whole_tasks((("K1", "K"), ("K", ""), ("L1", "L"), ("L2", "L"), ("L", "")))
    assert found == (("K1", ("K1",)), ("K", ("K",)), ("L", ("L1", "L2")), ("L", ("L",)))
    assert [each.is_cable for each in found] == [False, False, True, False]
