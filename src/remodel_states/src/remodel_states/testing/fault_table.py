"""The table of faults, as the fake cell reads it."""

from __future__ import annotations

from remodel_states.edge.exported_tables import read_faults
from remodel_states.testing.faults import Cure, InjectedFault, fault_from


class FaultTable:
    """What can go wrong, by name."""

    def __init__(self) -> None:
        """Read the tables of all packages."""
        tables = read_faults()
        self._rows, self._codes = tables.faults, tables.numbers

    def fault(self, name: str, cure: str = "", **given: object) -> InjectedFault:
        """Return a fault to be caused.

        Args:
            name: as in faults.yaml.
            cure: name of a Cure; empty: it passes by itself.
            given: other fields of the Fault, such as nth and wire.

        Raises:
            ValueError: if there is no such fault or cure, or a value is out of range.
        """
        if name not in self._rows:
            raise ValueError(f"no fault {name!r}; there are: {', '.join(self._rows)}")
        cures = [item.value for item in Cure]
        if cure and cure not in cures:
            raise ValueError(f"no cure {cure!r} of {name}; there are: {', '.join(cures)}")
        chosen = {"cure": Cure(cure)} if cure else {}
        return fault_from(self._rows[name], self._codes, **chosen, **given)
