"""The README of remodel_msgs states the times of the contract."""

import re
from pathlib import Path

from remodel_states.core import contract

README = Path(__file__).parents[3] / "remodel_msgs" / "README.md"


def test_the_readme_states_each_time():
    rows = re.findall(r"^\| .* \| ([0-9.]+) s \| .* \|$", README.read_text(), re.MULTILINE)
    times = {
        name: value for name, value in vars(contract).items() if re.fullmatch("[A-Z].*_S", name)
    }
    assert sorted(map(float, rows)) == sorted(times.values())
