"""Errors of the cell and of what it works on."""

from remodel_states.core import ability_error
from remodel_states.core.codes import Code


class CellError(Exception):
    """Base of the errors that the cell reports to its clients."""


class AbilityError(ability_error.AbilityError, CellError):
    """An ability cannot do, or did not manage, what its goal asks.

    Attributes:
        code: the physical or contractual cause.
    """

    code: Code

    def __init__(self, code: Code, message: str, **found: object) -> None:
        """State what was asked, what was found, and what to do.

        Args:
            code: see the class.
            message: the text.
            found: what was measured before it failed, by the name of the result's field.
        """
        super().__init__(code, message, found)


class PanelError(CellError):
    """A panel breaks the layout rules.

    Attributes:
        problems: every problem found, one sentence each.
    """

    def __init__(self, name: str, problems: tuple[str, ...]) -> None:
        """List every problem at once."""
        lines = "\n".join(f"  - {problem}" for problem in problems)
        super().__init__(f"panel {name!r} cannot be built ({len(problems)} problems):\n{lines}")
        self.problems = problems


class CellFileError(CellError):
    """A cell's file cannot be read or is invalid.

    Attributes:
        problems: every problem found: its place in the file, what was found, what is allowed.
    """

    def __init__(self, file: str, problems: tuple[str, ...]) -> None:
        """List every problem at once."""
        lines = "\n".join(f"  - {problem}" for problem in problems)
        super().__init__(f"cell {file}: {len(problems)} problems:\n{lines}")
        self.problems = problems


class MemoryFileError(CellError):
    """The memory of a cell cannot be read or written."""
