"""Whether a behavior can be loaded, checked and saved by the App, and is the same afterwards."""

from __future__ import annotations

import ast
import difflib
from collections.abc import Iterator, Mapping

from flexbe_testing.app.check import check_behavior
from flexbe_testing.app.known import Known
from flexbe_testing.app.load import load_behavior
from flexbe_testing.app.save import behavior_class, save_behavior
from flexbe_testing.app.text import AppLoadError

_SHOWN = 6  # changed lines that a complaint shows


def judge(text: str, known: Known) -> list[str]:
    """Return what keeps the App from loading and saving a behavior without a change.

    Args:
        text: the behavior's file.
        known: the states and behaviors of the workspace.
    """
    try:
        behavior = load_behavior(text, known)
    except AppLoadError as error:
        return [f"the App cannot load it: {error}"]
    complaints = list(behavior.lost)
    complaints += [f"the App does not save it: {why}" for why in check_behavior(behavior)]
    if behavior.class_name != behavior_class(behavior.name):
        complaints.append(f"the App saves it as class {behavior_class(behavior.name)}")
    if complaints:
        return complaints
    try:
        complaints += _changes(text, save_behavior(behavior, known, with_defaults=False), known)
        saved = save_behavior(behavior, known)
        if save_behavior(load_behavior(saved, known), known) != saved:
            complaints.append("what the App saves, it loads as something else")
    except (AppLoadError, SyntaxError) as error:
        complaints.append(f"the App saves what cannot be read: {error}")
    return complaints


def saved_by_app(text: str, known: Known) -> str:
    """Return the file that the App makes of a behavior's file.

    Raises:
        AppLoadError: if the App cannot load it.
    """
    return save_behavior(load_behavior(text, known), known)


def _changes(text: str, saved: str, known: Known) -> Iterator[str]:
    """Yield a complaint if the code is not the same, comments left out."""
    parameters = {f"{s.module}.{s.class_name}": list(s.parameters) for s in known.states}
    before, after = (_code_lines(source, parameters) for source in (text, saved))
    changed = [line for line in difflib.ndiff(before, after) if line[0] in "+-"]
    if changed:
        shown = "\n".join(f"    {line}" for line in changed[:_SHOWN])
        yield f"saving changes the code:\n{shown}"


def _code_lines(source: str, parameters: Mapping[str, list[str]]) -> list[str]:
    """Return the statements, without what differs though it means the same.

    That is the order of keyword arguments, a state's arguments without keyword (`parameters` has
    the names by the state's module and class), the blanks of a docstring, and the names under which
    classes are imported: the App renames states when another package has one of the same name. So
    the imports are left out, and each imported name has its module before it.
    """
    tree = ast.parse(source)
    imports = [node for node in tree.body if isinstance(node, ast.ImportFrom)]
    aliases = {n.asname or n.name: f"{i.module}.{n.name}" for i in imports for n in i.names}
    tree.body = [node for node in tree.body if node not in imports]
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            named = parameters.get(aliases.get(getattr(node.func, "id", ""), ""), [])
            nameless = node.args[: len(named)]
            node.keywords += [ast.keyword(n, v) for n, v in zip(named, nameless, strict=False)]
            del node.args[: len(named)]
            node.keywords.sort(key=lambda keyword: keyword.arg or "")
        elif isinstance(node, ast.Name):
            node.id = aliases.get(node.id, node.id)
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            node.value.value = " ".join(str(node.value.value).split())
    return ast.unparse(tree).splitlines()
