"""A state's docstring, which the FlexBE App reads, agrees with its code."""

import ast
import re
from pathlib import Path

from flexbe_testing.core.app_behavior import judge_state, read_state
from remodel_states.core.contract import GRACE_S

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


def parameters(node):
    init = next(n for n in node.body if getattr(n, "name", "") == "__init__")
    return [argument.arg for argument in init.args.args[1:]]


def test_docstring_and_code_agree():
    assert len(FILES) > 10
    for file in FILES:
        node = state_class(file)
        text, keywords = ast.get_docstring(node), declared(node)
        assert documented(text, "--") == parameters(node), file.name
        assert documented(text, ">#") == keywords["input_keys"], file.name
        assert documented(text, "#>") == keywords["output_keys"], file.name
        assert documented(text, "<=") == keywords["outcomes"], file.name


def test_each_ability_state_documents_the_time_beyond_its_timeout():
    calling = [file for file in FILES if "AbilityCall(" in file.read_text()]
    assert len(calling) > 10
    for file in calling:
        limit = re.search(r"-- timeout_s .*", ast.get_docstring(state_class(file)))
        assert f"[grace {GRACE_S:g} s]" in limit[0], file.name


def test_file_and_class_have_the_same_name():
    names = {file.stem: state_class(file).name for file in FILES}
    assert names == {s: "".join(word.capitalize() for word in s.split("_")) for s in names}


def test_the_app_sees_all_of_each_state():
    for file in FILES:
        node, text, module = state_class(file), file.read_text(), f"remodel_states.{file.stem}"
        hidden = judge_state(text, module)
        if node.name == "PlacePinState":  # outcomes of Deliverable 5.1 have blanks
            assert ["reads outcome" in complaint for complaint in hidden] == [True, True]
        else:
            assert hidden == [], file.name
        seen, keywords = read_state(text, module), declared(node)
        assert list(seen.parameters) == parameters(node), file.name
        assert list(seen.input_keys) == keywords["input_keys"], file.name
        assert list(seen.output_keys) == keywords["output_keys"], file.name
