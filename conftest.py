"""What tests of all packages share: fresh random input, and a disk that is full.

Random input comes from a seed that is printed and can be given.

`make test` draws few examples of each kind, `make test-all` many (`--hypothesis-profile=all`).
`pytest --fresh-seed N` draws those of an earlier run again.
"""

import resource
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from random import SystemRandom
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

for name, examples in (("quick", 15), ("all", 1000)):
    settings.register_profile(
        name,
        max_examples=examples,
        deadline=None,  # machines are busy
        database=None,
        suppress_health_check=list(HealthCheck),
    )
settings.load_profile("quick")


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the seed of all random input."""
    parser.addoption("--fresh-seed", type=int, help="draw the random input of an earlier run")


@pytest.hookimpl(tryfirst=True)
def pytest_configure(config: pytest.Config) -> None:
    """Choose the seed, which all workers share, before Hypothesis reads it."""
    if hasattr(config, "workerinput"):
        config.option.fresh_seed = config.workerinput["fresh_seed"]
    elif config.option.fresh_seed is None:
        config.option.fresh_seed = SystemRandom().randrange(10**6, 10**9)
    config.option.hypothesis_seed = config.option.fresh_seed


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:  # noqa: ANN401 - of a plug-in without types
    """Hand the seed to a worker."""
    node.workerinput["fresh_seed"] = node.config.option.fresh_seed


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Print the seed."""
    seed = terminalreporter.config.option.fresh_seed
    terminalreporter.write_line(f"random input: --fresh-seed {seed}")


@pytest.fixture(scope="session")
def fresh_seed(pytestconfig: pytest.Config) -> int:
    """Return the seed of this run's random input; others may be counted from it."""
    return pytestconfig.option.fresh_seed


@pytest.fixture
def full_disk() -> Callable[[], AbstractContextManager[None]]:
    """Return a context in which no file can grow: to write one fails as it does on a full disk."""

    @contextmanager
    def full() -> Iterator[None]:
        soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (0, hard))
        try:
            yield
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))

    return full
