"""Read a behavior's interface from the text of its file; nothing is imported.

The file is laid out as the FlexBE App writes it: `add_parameter` in `__init__`, and in `create` a
root container with keyword arguments, its default userdata, and a `return` of it.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator

from flexbe_synthesizer.core.library.manifest import Manifest
from flexbe_synthesizer.core.library.signature import BehaviorClass, Parameter, Port, Unreadable

_CONTAINERS = ("OperatableStateMachine", "ConcurrencyContainer", "PriorityContainer")
_KINDS = {"numeric": "float", "boolean": "bool", "text": "string", "enum": "string"}


def read_behavior_class(text: str, manifest: Manifest) -> BehaviorClass | Unreadable:
    """Return the interface of the behavior that a manifest names, or why it cannot be read."""
    try:
        return _read_class(ast.parse(text), manifest)
    except (SyntaxError, ValueError, RecursionError) as error:
        return Unreadable(manifest.name, manifest.package, str(error), manifest.class_name)


def _read_class(tree: ast.Module, manifest: Manifest) -> BehaviorClass:
    classes = [node for node in tree.body if isinstance(node, ast.ClassDef)]
    found = next((c for c in classes if c.name == manifest.class_name), None)
    if found is None:
        raise ValueError(f"its file has no class {manifest.class_name}")
    methods = {node.name: node for node in found.body if isinstance(node, ast.FunctionDef)}
    if not {"__init__", "create"} <= methods.keys():
        raise ValueError("its class lacks __init__ or create")
    root, returned = _root_container(methods["create"])
    lists = {k.arg: k.value for k in root.keywords}
    defaults = dict(_default_userdata(methods["create"], returned))
    kinds = {parameter.name: parameter.kind for parameter in manifest.parameters}
    return BehaviorClass(
        name=manifest.name,
        class_name=manifest.class_name,
        package=manifest.package,
        module=f"{manifest.package}.{manifest.module}",
        outcomes=_strings(lists.get("outcomes")),
        inputs=tuple(
            Port(key, optional=not _is_none(defaults.get(key)))
            for key in _strings(lists.get("input_keys"))
        ),
        outputs=tuple(Port(key) for key in _strings(lists.get("output_keys"))),
        parameters=tuple(
            Parameter(name, _KINDS.get(kinds.get(name, "")), required=False)
            for name in _parameter_names(methods["__init__"])
        ),
        contains=manifest.contains,
    )


def _root_container(create: ast.FunctionDef) -> tuple[ast.Call, str]:
    """Return the call that makes the root container, and the variable that holds it."""
    last = create.body[-1]
    if not (isinstance(last, ast.Return) and isinstance(last.value, ast.Name)):
        raise ValueError("its create does not end by returning the root container")
    returned = last.value.id
    for node in create.body:
        if (
            isinstance(node, ast.Assign)
            and [ast.unparse(target) for target in node.targets] == [returned]
            and isinstance(node.value, ast.Call)
            and ast.unparse(node.value.func) in _CONTAINERS
        ):
            return node.value, returned
    raise ValueError(f"its create does not assign a container to {returned}")


def _default_userdata(create: ast.FunctionDef, root: str) -> Iterator[tuple[str, ast.expr]]:
    """Yield key and value of each `root.userdata.key = value`."""
    for node in create.body:
        if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Attribute):
            target = node.targets[0]
            if ast.unparse(target.value) == f"{root}.userdata":
                yield target.attr, node.value


def _parameter_names(constructor: ast.FunctionDef) -> Iterator[str]:
    for node in ast.walk(constructor):
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "self.add_parameter":
            yield str(ast.literal_eval(node.args[0]))


def _strings(value: ast.expr | None) -> tuple[str, ...]:
    return () if value is None else tuple(map(str, ast.literal_eval(value)))


def _is_none(value: ast.expr | None) -> bool:
    return value is None or (isinstance(value, ast.Constant) and value.value is None)
