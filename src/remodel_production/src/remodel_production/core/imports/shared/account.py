"""What an import read, assumed and left out, with places in the file."""

from __future__ import annotations

from dataclasses import dataclass

from remodel_production.core.production import Order
from remodel_run.findings import Account, LeftOut

__all__ = ["Account", "Imported", "LeftOut"]


@dataclass(frozen=True)
class Imported:
    """An order, and the account of how it came about."""

    order: Order
    account: Account
