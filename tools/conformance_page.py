"""The text of docs/reference/conformance.md."""

from remodel_states.conformance.clauses import CLAUSES, TRIALS

HEAD = """\
# Conformance of ability servers

What every ability server keeps, and how `rosrun remodel_states conformance` finds out. It knows
no ability: it sends the goal that you give it, and goals made from that one.
Written by `make generate` from the tables that the command uses
([clauses.py](../../src/remodel_states/src/remodel_states/conformance/clauses.py)).

```sh
rosrun remodel_states conformance remodel_abilities/detectcable DetectCable --goal '{cable_id: W1}'
```

The goal is really done, several times: keep clear of the robot. Each trial is `ok`, `BROKEN`
with the names of the clauses in brackets, or `not judged` with the reason. `not judged` says
nothing about the server: give a goal that takes longer (five seconds or more), with all names
set, and `--restart`. Exit codes: 0 nothing that was judged is broken, 1 something is broken, 2 the
server cannot be tried, 130 interrupted.

## Trials

| trial | what the server gets | judges besides the clauses of every goal | not judged when |
|---|---|---|---|
"""

CLAUSES_HEAD = """
## Clauses

The clauses that no trial above names are judged for every goal that is sent.

| clause | what it requires |
|---|---|
"""

TIMES = """
The times of the contract are in the [numbers](numbers.md#abilities). What an ability does is not
checked here: test it in the cell, or in the simulated one.
"""


def conformance_page() -> str:
    """Return the page."""
    trials = [
        f"| {kind.name} | {kind.sent} | {', '.join(f'`{name}`' for name in kind.clauses) or '-'} "
        f"| {kind.unjudged or 'never'} |\n"
        for kind in TRIALS
    ]
    clauses = [f"| `{name}` | {requires} |\n" for name, requires in CLAUSES.items()]
    return "".join([HEAD, *trials, CLAUSES_HEAD, *clauses, TIMES])
