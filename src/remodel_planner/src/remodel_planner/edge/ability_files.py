"""The abilities that remodel_msgs defines."""

from __future__ import annotations

from pathlib import Path

import rospkg

from remodel_planner.core.ability import Ability, ability_of


def read_abilities() -> tuple[Ability, ...]:
    """Return the abilities of the installed action files, by name."""
    folder = Path(rospkg.RosPack().get_path("remodel_msgs")) / "action"
    return tuple(
        ability_of(file.stem, file.read_text(encoding="utf-8"))
        for file in sorted(folder.glob("*.action"))
    )
