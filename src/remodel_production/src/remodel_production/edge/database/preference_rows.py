"""An order's preferences and constraints to rows and back.

The document (docs/planning.md) has sections; each entry of a section is a row: of `require` among
the constraints, of any other one among the preferences.
"""

from __future__ import annotations

from typing import Any

from sqlalchemy import insert, select
from sqlalchemy.engine import Connection

from remodel_production.edge.database.production_models import ConstraintRow, PreferenceRow
from remodel_production.errors import OrderError

_REQUIRE = "require"


def add_preference_rows(connection: Connection, order_id: int, document: object) -> None:
    """Add the rows of an order's preferences; none for no document.

    Raises:
        OrderError: if the document has no sections.
    """
    if document is None:
        return
    if not isinstance(document, dict):
        raise OrderError(
            f"the preferences are a {type(document).__name__}; sections are needed: prefer, "
            "require, weights"
        )
    for section, entries in document.items():
        is_mapping = isinstance(entries, dict)
        rules = [{key: entries[key]} for key in entries] if is_mapping else entries
        if not isinstance(rules, list):
            rules = [rules]
        table = ConstraintRow if section == _REQUIRE else PreferenceRow
        rows = [
            {
                "order_id": order_id,
                "section": str(section),
                "position": position,
                "name": str(rule.get("name", "")) if isinstance(rule, dict) else "",
                "rule": {"entry": rule, "of": type(entries).__name__},
            }
            for position, rule in enumerate(rules)
        ]
        if rows:
            connection.execute(insert(table), rows)


def preferences_of_rows(connection: Connection, order_id: int) -> dict[str, Any] | None:
    """Return the document of an order's preferences, None if it has none."""
    document: dict[str, Any] = {}
    for table in (PreferenceRow, ConstraintRow):
        asked = select(table).where(table.order_id == order_id).order_by(table.id)
        for row in connection.execute(asked):
            entry = row.rule["entry"]
            if row.rule["of"] == "dict":
                document.setdefault(row.section, {}).update(entry)
            elif row.rule["of"] == "list":
                document.setdefault(row.section, []).append(entry)
            else:
                document[row.section] = entry
    return document or None
