"""Docstrings follow the grammar that the FlexBE App reads, and describe what the code does.

-- parameter type text      ># input key type text
#> output key type text     <= outcome text
"""

import ast
import re
from pathlib import Path

SOURCES = sorted((Path(__file__).parents[2] / "src" / "flexbe_states").glob("*_state.py"))
MARKERS = {"--": "parameters", ">#": "input_keys", "#>": "output_keys", "<=": "outcomes"}

# What the constructor takes from a parameter of this name is declared by the caller.
BY_CALLER = {"outcomes", "input_keys"}


def state_class(path):
    (definition,) = [n for n in ast.parse(path.read_text()).body if isinstance(n, ast.ClassDef)]
    return definition


def documented(definition):
    """Map each kind of entry to its names, in order."""
    found = {kind: [] for kind in MARKERS.values()}
    for line in ast.get_docstring(definition).splitlines():
        match = re.match(r"(--|>#|#>|<=)\s+(\S+)", line)
        if match:
            found[MARKERS[match[1]]].append(match[2])
    return found


def declared(definition):
    """Return what the constructor takes and declares; names only, as the App finds them."""
    (init,) = [n for n in definition.body if getattr(n, "name", "") == "__init__"]
    calls = [n for n in ast.walk(init) if isinstance(n, ast.Call)]
    (call,) = [c for c in calls if getattr(c.func, "attr", "") == "__init__"]
    found = {"parameters": [a.arg for a in init.args.args[1:]]}
    for kind in ("input_keys", "output_keys", "outcomes"):
        values = [k.value for k in call.keywords if k.arg == kind]
        found[kind] = []
        for value in values:
            if isinstance(value, ast.List):
                found[kind] = [item.value for item in value.elts]
            else:
                assert value.id in BY_CALLER
                found[kind] = ["by the caller"]
    return found


def test_a_docstring_documents_what_the_state_declares():
    assert SOURCES
    for path in SOURCES:
        documents, code = documented(state_class(path)), declared(state_class(path))
        assert documents["parameters"] == code["parameters"], path.name
        for kind in ("input_keys", "output_keys", "outcomes"):
            if code[kind] != ["by the caller"]:
                assert documents[kind] == code[kind], (path.name, kind)


def test_the_only_base_is_event_state():
    bases = {path.name: [base.id for base in state_class(path).bases] for path in SOURCES}
    assert {name: found for name, found in bases.items() if found != ["EventState"]} == {}


def test_file_and_class_have_the_same_name():
    words = [re.sub(r"(?<!^)(?=[A-Z])", "_", state_class(p).name).lower() for p in SOURCES]
    assert words == [path.stem for path in SOURCES]
