"""What runs teach is honest about what it does not know, and never costs more than it may."""

from random import Random

import pytest

from remodel_planner.core.learning.belief import Belief
from remodel_planner.core.learning.duration_model import DurationModel
from remodel_planner.core.learning.learned_expectations import Call, LearnedExpectations
from remodel_planner.core.learning.parameter_choice import GuardRail, ParameterChoice
from remodel_planner.core.learning.success_model import SuccessModel, fold
from remodel_planner.edge.use_case_files import find_use_case

THIN = ("InsertCable", "clamp", "0.5")
THICK = ("InsertCable", "clamp", "2.5")
GUARD = GuardRail(share=0.02, slack=5.0, credit=5.0)
VALUES = (10.0, 20.0, 30.0)


def trials(context, successes, failures):
    return [(context, True)] * successes + [(context, False)] * failures


def test_nothing_learned_is_what_the_use_case_states():
    belief = SuccessModel().belief(THIN, 0.9)
    assert belief.mean == pytest.approx(0.9)
    low, high = belief.interval()
    assert low < 0.75 < 0.9 < high


def test_many_trials_win_over_what_was_stated():
    model = fold(trials(THIN, 20, 80))
    assert model.belief(THIN, 0.99).mean == pytest.approx(0.2, abs=0.1)


def test_a_new_context_starts_from_its_relatives():
    model = fold(trials(THIN, 5, 45))
    assert model.belief(THICK, 0.95).mean < 0.4
    assert model.belief(("PickCable",), 0.95).mean == pytest.approx(0.95)


def test_uncertainty_shrinks_with_trials():
    widths = []
    for count in (0, 10, 100):
        low, high = fold(trials(THIN, count, count)).belief(THIN, 0.5).interval()
        widths.append(high - low)
    assert widths == sorted(widths, reverse=True)


def test_the_interval_holds_what_it_says():
    inside = 0
    for seed in range(400):
        random = Random(seed)
        truth = random.uniform(0.05, 0.95)
        model = SuccessModel()
        for _ in range(40):
            model.learn(("A",), random.random() < truth)
        low, high = model.belief(("A",), truth).interval()
        inside += low <= truth <= high
    assert inside / 400 >= 0.85


def test_an_ability_that_changes_is_followed():
    model = fold(trials(THIN, 1000, 0) + trials(THIN, 0, 300))
    assert model.belief(THIN, 0.9).mean < 0.3


def test_a_belief_lies_between_0_and_1():
    for belief in (Belief(0.01, 5.0), Belief(5.0, 0.01), Belief(1.0, 1.0)):
        low, high = belief.interval()
        assert 0.0 <= low <= high <= 1.0


def test_durations_are_learned_and_one_that_hung_does_not_spoil_them():
    model = DurationModel()
    assert model.belief(THIN, 10.0).mean_s == pytest.approx(10.0)
    for duration_s in [4.0] * 40 + [120.0]:
        model.learn(THIN, duration_s)
    assert model.belief(THIN, 10.0).median_s == pytest.approx(4.5, abs=0.7)
    assert model.belief(THICK, 10.0).median_s < 7.0


def play(truths, seed, count=1500):
    """Return the expected successes lost against the frozen value, after each trial.

    Args:
        truths: trial number -> value -> probability of success.
        seed: of all that is random.
        count: of trials.
    """
    random = Random(seed)
    choice = ParameterChoice(VALUES, 10.0, GUARD)
    lost, losses = 0.0, []
    for trial in range(count):
        truth = truths(trial)
        value = choice.choose(THIN, random)
        lost += truth[10.0] - truth[value]
        losses.append(lost)
        choice.learn(THIN, value, random.random() < truth[value])
    return losses


def steady(trial):
    return {10.0: 0.8, 20.0: 0.95, 30.0: 0.6}


def all_worse(trial):
    return {10.0: 0.95, 20.0: 0.6, 30.0: 0.3}


def collapse(trial):
    """The best value of the beginning becomes the worst, again and again."""
    good = (trial // 300) % 2 == 0
    return {10.0: 0.9, 20.0: 0.97 if good else 0.2, 30.0: 0.2 if good else 0.95}


def frozen_breaks(trial):
    return {10.0: 0.9 if trial < 400 else 0.4, 20.0: 0.9, 30.0: 0.85}


@pytest.mark.parametrize("seed", range(5))
def test_the_better_value_is_found(seed):
    losses = play(steady, seed)
    assert losses[-1] < -100


@pytest.mark.parametrize("truths", [steady, all_worse, collapse, frozen_breaks])
@pytest.mark.parametrize("seed", range(20))
def test_learning_never_costs_more_than_the_guard_rail(truths, seed):
    for trial, lost in enumerate(play(truths, seed), 1):
        assert lost <= GUARD.share * trial + GUARD.slack


def test_the_frozen_value_must_be_safe():
    with pytest.raises(ValueError, match="not among the safe ones"):
        ParameterChoice(VALUES, 15.0)


STATED = find_use_case("switchgear").expectations
FEATURES = {"section_mm2": 2.5}


def calls(count, error_code=0, elapsed_s=6.3, features=FEATURES, ability="InsertCable"):
    return [Call(ability, features, error_code, elapsed_s)] * count


def test_without_records_the_stated_is_expected():
    learned = LearnedExpectations(STATED)
    stated = STATED.expect("InsertCable", FEATURES)
    expected = learned.expect("InsertCable", FEATURES)
    assert expected.duration_s == pytest.approx(stated.duration_s)
    assert expected.success == pytest.approx(stated.success)


def test_records_change_what_is_expected():
    learned = LearnedExpectations(STATED, [*calls(60, elapsed_s=12.6), *calls(40, error_code=301)])
    expected = learned.expect("InsertCable", FEATURES)
    assert expected.success < 0.75
    assert expected.duration_s > 1.5 * STATED.expect("InsertCable", FEATURES).duration_s


def test_what_says_nothing_of_the_ability_is_left_out():
    learned = LearnedExpectations(STATED, [*calls(50, error_code=4), *calls(9, ability="Sing")])
    assert learned.calls == 0
