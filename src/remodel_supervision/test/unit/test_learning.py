"""What runs teach is honest about what it does not know, and never costs more than it may."""

import math
from random import Random

import pytest
from taught import TAUGHT, forced

from remodel_supervision.core.learning.belief import (
    Belief,
    DurationModel,
    GuardRail,
    ParameterChoice,
    SuccessModel,
)
from remodel_supervision.core.learning.experience import (
    REHEARSED_WEIGHT,
    Call,
    Experience,
    LearnedExpectations,
    LearnedParameters,
    LearnedResponses,
    TriedResponse,
    numbers_from,
    tried_responses,
)
from remodel_tasks.core.condition import context_of, terminal_features
from remodel_tasks.core.use_case.fault import Do
from remodel_tasks.core.use_case.model import Bounds, frozen_setting, nearer_settings, settings
from remodel_tasks.edge.use_case_files import find_use_case

THIN = ("InsertCable", "clamp", "0.5")
THICK = ("InsertCable", "clamp", "2.5")
VALUES = (10.0, 20.0, 30.0)


def trained(trials):
    """Return the model that has learned from these trials."""
    model = SuccessModel()
    for context, success in trials:
        model.learn(context, success)
    return model


def trials(context, successes, failures):
    return [(context, True)] * successes + [(context, False)] * failures


def test_nothing_learned_is_what_the_use_case_states():
    belief = SuccessModel().belief(THIN, 0.9)
    assert belief.mean == pytest.approx(0.9)
    low, high = belief.interval()
    assert low < 0.75 < 0.9 < high


def test_many_trials_win_over_what_was_stated():
    model = trained(trials(THIN, 20, 80))
    assert model.belief(THIN, 0.99).mean == pytest.approx(0.2, abs=0.1)


def test_a_new_context_starts_from_its_relatives():
    model = trained(trials(THIN, 5, 45))
    assert model.belief(THICK, 0.95).mean < 0.4
    assert model.belief(("PickCable",), 0.95).mean == pytest.approx(0.95)


def test_uncertainty_shrinks_with_trials():
    widths = []
    for count in (0, 10, 100):
        low, high = trained(trials(THIN, count, count)).belief(THIN, 0.5).interval()
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
    model = trained(trials(THIN, 1000, 0) + trials(THIN, 0, 300))
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


def play(truths, seed, count=1000, contexts=(THIN,)):
    """Return what each trial was expected to lose against the frozen value.

    Args:
        truths: trial number -> value -> probability of success.
        seed: of all that is random.
        count: of trials.
        contexts: of the trials; one of them at random.
    """
    random = Random(seed)
    choice = ParameterChoice(VALUES, 10.0)
    losses = []
    for trial in range(count):
        truth, context = truths(trial), random.choice(contexts)
        value = choice.choose(context, random)
        losses.append(truth[10.0] - truth[value])
        choice.learn(context, value, random.random() < truth[value])
    return losses


def worst_stretch(losses, share):
    """Return the greatest loss beyond that share of the trials, of any stretch of them."""
    worst = stretch = 0.0
    for loss in losses:
        stretch = max(0.0, stretch + loss - share)
        worst = max(worst, stretch)
    return worst


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


def frozen_recovers(trial):
    """Only the value that is hardly tried any more becomes better: only trying shows it."""
    return {10.0: 0.55 if trial < 400 else 0.98, 20.0: 0.9, 30.0: 0.7}


def optimum(at, width):
    return {value: 0.97 * math.exp(-(((value - at) / width) ** 2)) for value in VALUES}


def best_jumps(trial):
    return optimum(22.0 if trial < 500 else 10.0, 12.0)


def best_wanders(trial):
    return optimum(18.0 + 9.0 * math.sin(trial / 150.0), 14.0)


DRIFTS = (
    steady,
    all_worse,
    collapse,
    frozen_breaks,
    frozen_recovers,
    best_jumps,
    best_wanders,
)


@pytest.mark.parametrize("seed", range(5))
def test_the_better_value_is_found(seed):
    assert sum(play(steady, seed)) < -0.6 * 1000 * (0.95 - 0.8)


@pytest.mark.parametrize("truths", DRIFTS)
@pytest.mark.parametrize("contexts", [(THIN,), (THIN, THICK)])
def test_no_stretch_of_trials_costs_more_than_the_guard_rail(truths, contexts):
    guard = GuardRail()
    for seed in range(5):
        losses = play(truths, seed, contexts=contexts)
        assert worst_stretch(losses, guard.share) <= guard.slack, seed


def test_a_guard_rail_of_nothing_leaves_the_frozen_value():
    choice = ParameterChoice(VALUES, 10.0, GuardRail(share=0.0, slack=0.0))
    assert {choice.choose(THIN, Random(seed)) for seed in range(50)} == {10.0}


def test_the_frozen_value_must_be_safe():
    with pytest.raises(ValueError, match="not among the safe ones"):
        ParameterChoice(VALUES, 15.0)


FORCE = {"force_limit": Bounds(14.0, 8.0, 20.0, 7)}


def test_bounds_hold_the_frozen_value_and_their_ends():
    assert Bounds(8.0, 4.0, 16.0, 4).values == (4.0, 8.0, 12.0, 16.0)
    assert Bounds(9.0, 4.0, 16.0, 4).values == (4.0, 9.0, 12.0, 16.0)
    assert Bounds(5.0, 5.0, 5.0).values == (5.0,)


def test_a_setting_is_expected_to_be_like_its_neighbour_towards_the_frozen_one():
    both = {"force_limit": Bounds(8.0, 4.0, 16.0, 4), "speed": Bounds(1.0, 1.0, 3.0, 3)}
    nearer = nearer_settings(both)
    assert set(nearer) == set(settings(both)) - {frozen_setting(both)}
    force, speed = "force_limit", "speed"
    assert nearer[(force, 16.0), (speed, 2.0)] == ((force, 12.0), (speed, 2.0))
    assert nearer[(force, 4.0), (speed, 3.0)] == ((force, 4.0), (speed, 2.0))
    learned = LearnedParameters([forced(12.0)] * 30)
    beliefs = learned.beliefs("InsertCable", {}, FORCE)
    assert beliefs[((force, 10.0),)].mean > 0.9
    assert beliefs[((force, 16.0),)].mean == pytest.approx(0.5)


@pytest.mark.parametrize("wrong", [(3.0, 4.0, 16.0, 4), (8.0, 4.0, 16.0, 1), (8.0, 4.0, math.inf)])
def test_senseless_bounds_are_refused(wrong):
    with pytest.raises(ValueError, match="low <= frozen <= high"):
        Bounds(*wrong)


def test_more_settings_than_can_be_distinguished_are_refused():
    many = {name: Bounds(8.0, 4.0, 16.0) for name in ("force_limit", "speed", "tilt")}
    with pytest.raises(ValueError, match="125 settings"):
        LearnedParameters().choose("InsertCable", {}, many, 1)


def test_what_succeeded_is_chosen_and_only_where_it_did():
    learned = LearnedParameters(TAUGHT)
    here = {"section_mm2": 2.5, "terminal_type": "clamp"}
    chosen = [learned.choose("InsertCable", here, FORCE, seed)["force_limit"] for seed in range(50)]
    assert chosen.count(12.0) > 45
    beliefs = learned.beliefs("InsertCable", here, FORCE)
    assert beliefs[(("force_limit", 12.0),)].mean > 0.9
    elsewhere = learned.beliefs("PickCable", here, FORCE)
    assert {belief.mean for belief in elsewhere.values()} == {0.5}


def test_the_same_calls_and_seed_choose_the_same():
    one, other = LearnedParameters(TAUGHT[:30]), LearnedParameters()
    for call in TAUGHT[:30]:
        other.learn(call)
    for seed in range(20):
        chosen = [each.choose("InsertCable", {}, FORCE, seed) for each in (one, other)]
        assert chosen[0] == chosen[1]


def test_calls_without_information_on_a_parameter_are_left_out():
    learned = LearnedParameters([forced(12.0, 4), Call("InsertCable", {}, 301, 5.0)])
    assert {b.mean for b in learned.beliefs("InsertCable", {}, FORCE).values()} == {0.5}
    learned.learn(forced(11.0))
    assert {b.mean for b in learned.beliefs("InsertCable", {}, FORCE).values()} == {0.5}


HERE = {"section_mm2": 2.5, "terminal_type": "clamp"}


def test_experience_chooses_within_what_is_allowed():
    cabinet = find_use_case("cabinet")
    experience = Experience(cabinet, TAUGHT, explore=True)
    chosen = {
        experience.parameters("InsertCable", HERE, {}, str(seed)).get("force_limit")
        for seed in range(50)
    }
    assert 12.0 in chosen
    assert 14.0 not in chosen, "the use case's own is left as it is"
    for seed in range(50):
        limited = experience.parameters("InsertCable", HERE, {"force_limit": 16.0}, str(seed))
        assert limited.get("force_limit", 14.0) <= 16.0
    assert experience.parameters("InsertCable", HERE, {"force_limit": 13.0}, "1") == {}
    assert experience.parameters("FixCable", HERE, {}, "1") == {}


@pytest.mark.parametrize("calls", [(), TAUGHT], ids=["empty database", "many runs"])
def test_no_force_but_the_stated_one_is_used_unless_exploring_is_asked_for(calls):
    experience = Experience(find_use_case("cabinet"), calls)
    for seed in range(50):
        assert experience.parameters("InsertCable", HERE, {}, str(seed)) == {}


def test_without_exploring_the_policy_is_followed_as_it_stands():
    cabinet = find_use_case("cabinet")
    hopeless = [TriedResponse("jammed", Do.RETRY, helped=False)] * 30
    assert Experience(cabinet).unpromising("jammed", {Do.RETRY}, hopeless) == frozenset()
    exploring = Experience(cabinet, explore=True)
    assert exploring.unpromising("jammed", {Do.RETRY}, hopeless) == {Do.RETRY}


def test_durations_and_successes_are_learned_without_exploring_too():
    cabinet = find_use_case("cabinet")
    stated = cabinet.expectations.expect("InsertCable", HERE)
    learned = Experience(cabinet, TAUGHT).expectations.expect("InsertCable", HERE)
    assert learned.success != stated.success


def test_a_terminal_has_the_features_that_success_may_depend_on():
    assert terminal_features("clamp", (0.0, -1.0, -0.0)) == {
        "terminal_type": "clamp",
        "approach": "0 -1 0",
    }
    assert terminal_features("", None) == {}


def test_numbers_are_read_from_an_operation():
    pairs = (("force_limit", "8.0"), ("cable_id", "W1"), ("timeout", "60.0"))
    assert numbers_from(pairs) == {"force_limit": 8.0, "timeout": 60.0}


def test_a_context_goes_from_the_general_to_the_special():
    features = {"view": "wrist", "section_mm2": 1.5, "colour": "BK", "terminal_type": "spring"}
    assert context_of("InsertCable", features) == (
        "InsertCable",
        "terminal_type=spring",
        "section_mm2=1.5",
        "view=wrist",
    )


STATED = find_use_case("cabinet").expectations
FEATURES = {"section_mm2": 2.5}


def calls(count, error_code=0, elapsed_s=10.0, features=FEATURES, ability="InsertCable"):
    return [Call(ability, features, error_code, elapsed_s)] * count


def test_without_records_the_stated_is_expected():
    learned = LearnedExpectations(STATED)
    stated = STATED.expect("InsertCable", FEATURES)
    expected = learned.expect("InsertCable", FEATURES)
    assert expected.duration_s == pytest.approx(stated.duration_s)
    assert expected.success == pytest.approx(stated.success)


def test_records_change_what_is_expected():
    learned = LearnedExpectations(STATED, [*calls(60, elapsed_s=20.0), *calls(40, error_code=301)])
    expected = learned.expect("InsertCable", FEATURES)
    assert expected.success < 0.75
    assert expected.duration_s > 1.5 * STATED.expect("InsertCable", FEATURES).duration_s


def test_what_says_nothing_of_the_ability_is_left_out():
    learned = LearnedExpectations(STATED, [*calls(50, error_code=4), *calls(9, ability="Sing")])
    assert learned.calls == 0


def test_what_follows_a_decision_shows_whether_it_helped():
    decisions = [("jammed", Do.RETRY), ("jammed", Do.NEW_PART), ("slipped", Do.RETRY)]
    responses = tried_responses(decisions, finished=True)
    assert [response.helped for response in responses] == [False, True, True]
    lasting = tried_responses([*decisions, ("slipped", Do.SET_ASIDE)], finished=False)
    assert [response.helped for response in lasting] == [False, True, False]
    assert tried_responses([], finished=True) == ()


def test_a_response_that_never_helps_is_passed_over_for_its_fault_only():
    learned = LearnedResponses([TriedResponse("jammed", Do.RETRY, False)] * 30)
    possible = {Do.RETRY, Do.NEW_PART, Do.ASK_OPERATOR}
    assert learned.promising("jammed", possible) == {Do.NEW_PART, Do.ASK_OPERATOR}
    assert learned.promising("slipped", possible) == possible
    assert LearnedResponses().promising("jammed", possible) == possible


def test_a_response_is_not_given_up_for_a_little_bad_luck():
    random = Random(1)
    given_up = 0
    for _ in range(200):
        responses = [TriedResponse("jammed", Do.RETRY, random.random() < 0.5) for _ in range(40)]
        learned = LearnedResponses()
        for response in responses:
            learned.learn(response)
            given_up += Do.RETRY not in learned.promising("jammed", {Do.RETRY})
    assert given_up == 0


def test_a_response_that_was_passed_over_gets_another_chance():
    learned = LearnedResponses([TriedResponse("jammed", Do.RETRY, False)] * 30)
    waited = 0
    while Do.RETRY not in learned.promising("jammed", {Do.RETRY}):
        learned.learn(TriedResponse("jammed", Do.NEW_PART, True))
        waited += 1
        assert waited < 300
    assert waited > 20


def test_five_rehearsed_calls_weigh_as_much_as_a_real_one():
    rehearsed, real = SuccessModel(), SuccessModel()
    for _ in range(5):
        rehearsed.learn(("InsertCable",), False, REHEARSED_WEIGHT)
    real.learn(("InsertCable",), False)
    assert rehearsed.belief(("InsertCable",), 0.9).mean == pytest.approx(
        real.belief(("InsertCable",), 0.9).mean, abs=1e-3
    )


def test_rehearsed_trials_of_another_setting_are_not_charged_to_the_robot():
    context = ("InsertCable",)
    choice = ParameterChoice([8.0, 14.0], 14.0)
    for _ in range(200):
        choice.learn_rehearsed(context, 8.0, False, REHEARSED_WEIGHT)
        choice.learn_rehearsed(context, 14.0, True, REHEARSED_WEIGHT)
    assert choice.beliefs(context)[8.0].mean < 0.2 < 0.8 < choice.beliefs(context)[14.0].mean
    # The account is untouched: the other setting is still tried when it looks better.
    for _ in range(400):
        choice.learn_rehearsed(context, 8.0, True, REHEARSED_WEIGHT)
        choice.learn_rehearsed(context, 14.0, False, REHEARSED_WEIGHT)
    assert choice.choose(context, Random(1)) == 8.0
