"""Fill in how wire ends go into terminals, where the design does not say it, by the catalogue.

Of all formats, lists alone have columns for the force with which an end may be pushed in; none says
how much room is around a terminal, or from where an end goes in. Each value
filled in is reported as an assumption, and so is each terminal with more wires than it takes.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

from remodel_production.core.catalogue import Catalogue, TerminalRule
from remodel_production.core.full_terminals import full_terminals
from remodel_production.core.imports.shared.account import Imported
from remodel_production.core.production import Component, Side, Terminal

# Into the component from the side on which the terminal opens, in the component's frame.
_APPROACHES = {Side.TOP: (0.0, -1.0, 0.0), Side.BOTTOM: (0.0, 1.0, 0.0)}


def with_access(imported: Imported, catalogue: Catalogue) -> Imported:
    """Return the order with approaches, clearances and force limits of all terminals.

    A rule of the catalogue that fits the component decides, the first one of several.
    """
    lacking: Counter[str] = Counter()
    components = []
    for component in imported.order.components:
        rule = catalogue.terminal_rule(component)
        lacking.update(_assumed(component, rule))
        terminals = tuple(_filled(terminal, rule) for terminal in component.terminals)
        components.append(replace(component, terminals=terminals))
    assumptions = (
        *(f"{what} (of {count} terminals)" for what, count in lacking.items()),
        *(
            f"{full.reason}; by hand: {', '.join(full.beyond)}"
            for full in full_terminals(imported.order.in_cabinet(), catalogue)
        ),
    )
    return Imported(
        replace(
            imported.order,
            components=tuple(components),
            notes=(*imported.order.notes, *assumptions),
        ),
        replace(imported.account, assumptions=(*imported.account.assumptions, *assumptions)),
    )


def _filled(terminal: Terminal, rule: TerminalRule) -> Terminal:
    limit, clearance = terminal.insertion_force_limit_n, terminal.clearance_m
    return replace(
        terminal,
        approach=terminal.approach or _APPROACHES[terminal.side],
        clearance_m=rule.clearance_m if clearance is None else clearance,
        insertion_force_limit_n=rule.force_limit_n if limit is None else limit,
    )


def _assumed(component: Component, rule: TerminalRule) -> Counter[str]:
    """Return a line for each assumed value, and for how many terminals."""
    kind = f"{component.role.value}s"
    terminals = component.terminals
    found = {
        f"insertion force limit not given, {rule.force_limit_n:g} N taken for {kind}": sum(
            t.insertion_force_limit_n is None for t in terminals
        ),
        f"clearance not given, {1e3 * rule.clearance_m:g} mm taken for {kind}": sum(
            t.clearance_m is None for t in terminals
        ),
        "approach not given, that from the side on which they open taken": sum(
            t.approach is None for t in terminals
        ),
    }
    return Counter({what: count for what, count in found.items() if count})
