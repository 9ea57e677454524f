"""A long list of problems is cut, and says how many are left out."""

from remodel_supervision.core.runs.step import abridged


def refusal(count):
    problems = "\n".join(f"  - problem {number}" for number in range(1, count + 1))
    return f"cannot be built ({count} problems):\n{problems}\nNothing has moved."


def test_the_first_problems_stay_and_the_others_are_counted():
    assert abridged(refusal(57)) == (
        "cannot be built (57 problems):\n  - problem 1\n  - problem 2\n  - problem 3\n"
        "  - and 54 more\nNothing has moved."
    )


def test_what_is_short_stays_as_it_is():
    for text in ("", "ann stopped it", refusal(3), refusal(4)):
        assert abridged(text) == text
    assert "and 2 more" in abridged(refusal(5))
