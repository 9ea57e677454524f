"""A workspace that has packages of stock FlexBE over this one can be configured."""

from pathlib import Path

import pytest
from catkin_pkg.package import Dependency
from catkin_pkg.packages import find_packages
from catkin_pkg.topological_order import topological_order_packages

SRC = Path(__file__).parents[1] / "src"

# Whose tests depend on what, in stock FlexBE, and not in this workspace.
STOCK = {"flexbe_states": ["flexbe_testing", "flexbe_input"]}


@pytest.mark.parametrize("name", STOCK)
def test_a_package_of_stock_flexbe_over_this_workspace_makes_no_cycle(name):
    packages = find_packages(str(SRC))
    (path,) = [path for path, package in packages.items() if package.name == name]
    stock = packages.pop(path)
    stock.test_depends += [Dependency(other) for other in STOCK[name]]
    order = topological_order_packages({path: stock}, underlay_packages=packages)
    cycles = [names for path, names in order if path is None]
    assert not cycles
