"""What a wire connects is compared with the design, end by end."""

import pytest

from remodel_planner.core.net_list import (
    Connection,
    FoundEnd,
    FoundWire,
    Verdict,
    net_list,
    share_in_ducts,
)
from remodel_production.core.production import TerminalRef, Wire

A, B, OTHER, THIRD = (TerminalRef("Q1", name) for name in ("1", "2", "3", "4"))


def connection(*ends):
    """Return a connection from A to B; ends are terminals, or (terminal, whether it is fixed)."""
    pairs = [end if isinstance(end, tuple) else (end, end is not None) for end in ends]
    found = FoundWire(*(FoundEnd(*pair) for pair in pairs)) if pairs else None
    return Connection("W1", (A, B), found)


@pytest.mark.parametrize("ends", [(A, B), (B, A)])
def test_a_wire_between_its_terminals_is_as_designed_either_way_round(ends):
    made = connection(*ends)
    assert (made.verdict, made.difference) == (Verdict.AS_DESIGNED, "")


@pytest.mark.parametrize(
    ("ends", "difference"),
    [
        ((), "no piece of it in the cell"),
        ((None, None), "no end in Q1:1 and Q1:2"),
        ((A, None), "no end in Q1:2"),
        ((A, (B, False)), "not fixed in Q1:2"),
        ((None, (B, False)), "no end in Q1:1; not fixed in Q1:2"),
    ],
)
def test_a_wire_that_does_not_reach_its_terminals_is_missing(ends, difference):
    made = connection(*ends)
    assert (made.verdict, made.difference) == (Verdict.MISSING, difference)


@pytest.mark.parametrize(
    ("ends", "difference"),
    [
        ((A, OTHER), "in Q1:3 instead of Q1:2"),
        ((OTHER, B), "in Q1:3 instead of Q1:1"),
        ((OTHER, THIRD), "in Q1:3 and Q1:4 instead of Q1:1 and Q1:2"),
        ((None, OTHER), "in Q1:3 instead of Q1:1 and Q1:2"),
        ((A, A), "in Q1:1 instead of Q1:2"),
        ((A, (OTHER, False)), "in Q1:3 instead of Q1:2; not fixed in Q1:3"),
    ],
)
def test_an_end_in_a_terminal_of_others_makes_the_wire_wrong(ends, difference):
    made = connection(*ends)
    assert (made.verdict, made.difference) == (Verdict.WRONG, difference)


def test_the_list_has_what_was_asked_for_and_what_is_there_in_the_designs_order():
    wires = [
        Wire(name, A, B, "BU", section_mm2=1.5, source="") for name in ("W1", "W2", "W3", "W4")
    ]
    there = FoundWire(FoundEnd(A, True), FoundEnd(B, True))
    nets = net_list(wires, ["W2", "W1"], {"W4": there})
    assert [(net.wire, net.verdict) for net in nets] == [
        ("W1", Verdict.MISSING),
        ("W2", Verdict.MISSING),
        ("W4", Verdict.AS_DESIGNED),
    ]


def test_the_share_in_ducts_is_that_of_the_length():
    def wire(length_m, share):
        return Connection(
            "W1", (A, B), FoundWire(FoundEnd(), FoundEnd(), duct_length_m=length_m, in_ducts=share)
        )

    assert share_in_ducts([wire(3.0, 1.0), wire(1.0, 0.0), wire(0.0, 0.0)]) == 0.75
    assert share_in_ducts([wire(0.0, 0.0), Connection("W2", (A, B), None)]) is None
