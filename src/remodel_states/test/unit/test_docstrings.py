"""A state's docstring, which the FlexBE App reads, agrees with its code."""

import ast
import re
from pathlib import Path

import pytest

from flexbe_testing.app.judge_state import judge_state
from flexbe_testing.app.states import read_state
from remodel_states.core.contract_times import GRACE_S

FILES = sorted((Path(__file__).parents[2] / "src" / "remodel_states").glob("*_state.py"))


def state_class(file):
    classes = [n for n in ast.parse(file.read_text()).body if isinstance(n, ast.ClassDef)]
    assert len(classes) == 1, f"{file.name}: the App reads one state a file"
    return classes[0]


def documented(text, mark):
    """Return the names after a mark; an outcome's name ends before two blanks."""
    pattern = rf"^\s*{mark} (.+?)(?:  |$)"
    return [match.strip() for match in re.findall(pattern, text, re.MULTILINE)]


def declared(node):
    """Return the keyword lists given to super().__init__."""
    for call in ast.walk(node):
        function = getattr(call, "func", None)
        if isinstance(function, ast.Attribute) and function.attr == "__init__":
            return {keyword.arg: ast.literal_eval(keyword.value) for keyword in call.keywords}
    raise AssertionError("no call of super().__init__")


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_docstring_and_code_agree(file):
    node = state_class(file)
    text = ast.get_docstring(node)
    keywords = declared(node)
    init = next(n for n in node.body if getattr(n, "name", "") == "__init__")
    parameters = [argument.arg for argument in init.args.args[1:]]
    assert documented(text, "--") == parameters
    assert documented(text, ">#") == keywords["input_keys"]
    assert documented(text, "#>") == keywords["output_keys"]
    assert documented(text, "<=") == keywords["outcomes"]


CALLING = [file for file in FILES if "AbilityCall(" in file.read_text()]


@pytest.mark.parametrize("file", CALLING, ids=lambda file: file.stem)
def test_each_ability_state_documents_the_time_beyond_its_timeout(file):
    limit = re.search(r"-- timeout_s .*", ast.get_docstring(state_class(file)))
    assert f"[grace {GRACE_S:g} s]" in limit[0]


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_the_app_sees_all_of_each_state(file):
    node = state_class(file)
    assert node.name == "".join(word.capitalize() for word in file.stem.split("_"))
    text, module = file.read_text(), f"remodel_states.{file.stem}"
    hidden = judge_state(text, module)
    if node.name == "PlacePinState":  # outcomes of Deliverable 5.1 have blanks
        assert ["reads outcome" in complaint for complaint in hidden] == [True, True]
    else:
        assert hidden == []
    seen, keywords = read_state(text, module), declared(node)
    init = next(n for n in node.body if getattr(n, "name", "") == "__init__")
    assert list(seen.parameters) == [argument.arg for argument in init.args.args[1:]]
    assert list(seen.input_keys) == keywords["input_keys"]
    assert list(seen.output_keys) == keywords["output_keys"]
