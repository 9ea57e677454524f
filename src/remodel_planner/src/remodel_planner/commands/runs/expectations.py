"""`remodel expectations USE_CASE`: print what was learned from runs about abilities."""

from __future__ import annotations

import argparse
from collections import Counter
from contextlib import closing

from remodel_planner.commands.options.common import add_database_option, refuses
from remodel_production.edge.database.production_database import ProductionDatabase
from remodel_supervision.core.learning.experience import (
    Call,
    LearnedExpectations,
    LearnedParameters,
    setting_of,
)
from remodel_supervision.edge.recorded_lessons import ability_calls
from remodel_tasks.core.use_case.model import UseCase, frozen_setting
from remodel_tasks.edge.use_case_files import find_use_case


@refuses("expectations")
def main(arguments: list[str] | None = None) -> int:
    """Print a line for each ability and section, and return the exit code."""
    parser = argparse.ArgumentParser(
        prog="remodel expectations",
        description="Print how long abilities are expected to take and how often to succeed, as "
        "the use case states it and as learned from recorded runs, and with which parameters; with "
        "the 90 % interval of the belief.",
        epilog="Exit code: 0 printed, 1 no such use case or database, 2 wrong usage.",
    )
    parser.add_argument("use_case", metavar="USE_CASE", help="such as cabinet")
    add_database_option(parser)
    options = parser.parse_args(arguments)
    use_case = find_use_case(options.use_case)
    with closing(ProductionDatabase(options.database)) as database:
        calls = ability_calls(database)
    _print_expectations(use_case, calls)
    for ability in use_case.learned:
        _print_settings(use_case, ability, calls)
    return 0


def _print_expectations(use_case: UseCase, calls: tuple[Call, ...]) -> None:
    learned = LearnedExpectations(use_case.expectations, calls)
    informative = [call for call in calls if call.is_informative]
    counts = Counter((call.ability, call.features["section_mm2"]) for call in informative)
    print(f"{'ability':<24}{'mm2':>5}{'calls':>7}   {'stated':<16}learned")
    for ability in use_case.expectations.stated:
        sections = sorted(section for name, section in counts if name == ability)
        for section in sections or [_default_section(use_case)]:
            features = {"section_mm2": section}
            stated = use_case.expectations.expect(ability, features)
            expected = learned.expect(ability, features)
            low, high = learned.belief(ability, features).interval()
            print(
                f"{ability:<24}{section:>5g}{counts[ability, section]:>7}   "
                f"{stated.duration_s:>5.1f} s {stated.success:>6.1%}  "
                f"{expected.duration_s:>5.1f} s {expected.success:>6.1%}  ({low:.0%} to {high:.0%})"
            )


def _print_settings(use_case: UseCase, ability: str, calls: tuple[Call, ...]) -> None:
    """Print what is believed about the settings that were tried of an ability's parameters."""
    bounds = use_case.learned[ability]
    tried = Counter(setting_of(bounds, call) for call in calls if call.ability == ability)
    beliefs = LearnedParameters(calls).beliefs(ability, {}, bounds)
    for setting in filter(tried.__contains__, beliefs):
        text = ", ".join(f"{name} {value:g}" for name, value in setting)
        frozen = "frozen" if setting == frozen_setting(bounds) else ""
        low, high = beliefs[setting].interval()
        print(
            f"{ability + ' ' + text:<29}{tried[setting]:>7}   {frozen:<16}"
            f"{'':>7} {beliefs[setting].mean:>6.1%}  ({low:.0%} to {high:.0%})"
        )


def _default_section(use_case: UseCase) -> float:
    characteristic = use_case.task_characteristics.get("section_mm2")
    return float(characteristic.default) if characteristic else 0.0
