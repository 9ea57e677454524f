"""The text of docs/reference/conformance.md."""

from remodel_states.conformance.clauses import CLAUSES, TRIALS

HEAD = """\
# Conformance of ability servers

What every ability server keeps, and how `rosrun remodel_states conformance` finds out: it sends the
goal that you give it, and goals made from that one. Written by `make generate` from
[clauses.py](../../src/remodel_states/src/remodel_states/conformance/clauses.py).

```sh
rosrun remodel_states conformance remodel_abilities/detectcable DetectCable --goal '{cable_id: W1}'
```

The goal is really done, several times: keep clear of the robot. A trial is `ok`, `BROKEN` with the
clauses in brackets, or `not judged`: give a goal that takes five seconds or more, with all names
set, and `--restart`. Exit codes: 0 nothing that was judged is broken, 1 something is broken, 2 the
server cannot be tried, 130 interrupted.

| trial | what the server gets | judges besides the clauses of every goal | not judged when |
|---|---|---|---|
"""

CLAUSES_HEAD = """
## Clauses of every goal that is sent

| clause | what it requires |
|---|---|
"""

TIMES = """
The times of the contract are in the [numbers](numbers.md). What an ability does is not checked.
"""


def conformance_page() -> str:
    """Return the page."""
    trials = [
        f"| {kind.name} | {kind.sent} "
        f"| {'<br>'.join(f'`{name}`: {CLAUSES[name]}' for name in kind.clauses) or '-'} "
        f"| {kind.unjudged or 'never'} |\n"
        for kind in TRIALS
    ]
    named = {name for kind in TRIALS for name in kind.clauses}
    clauses = [f"| `{name}` | {text} |\n" for name, text in CLAUSES.items() if name not in named]
    return "".join([HEAD, *trials, CLAUSES_HEAD, *clauses, TIMES])
