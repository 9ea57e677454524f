"""What packages hold, read from text alone: classes of states, and manifests of behaviors.

A file counts if a class in it has the base list `(EventState)`. Its constructor calls
`super().__init__` with `outcomes`, `input_keys`, `output_keys` (and `io_keys`), each a list of
strings or the name of a constructor argument. The docstring gives the types, one mark a line:
`-- name type text` argument, `># name type text` input, `#> name type text` output. An argument
without a type is a string if its default is one. An outcome, `<= name text`, writes all outputs,
unless its text holds `[writes key, key]` or `[writes nothing]`. An argument that limits the time of
a visit, which may last longer, has `[grace 2 s]` in its text.
"""

from __future__ import annotations

import ast
import html
import keyword
import re
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from flexbe_synthesizer.core.chart import names
from flexbe_synthesizer.core.chart.model import freeze, python_literal
from flexbe_synthesizer.core.chart.problem import ChartError
from flexbe_synthesizer.core.chart.xml_tree import XmlTree, as_utf8, read_root
from flexbe_synthesizer.core.library.signature import (
    BehaviorClass,
    Effect,
    FromParameter,
    Parameter,
    Port,
    StateClass,
    Unreadable,
    documented_type,
)

AUTHOR = "REMODEL planner developers"  # the FlexBE App wants one, where a chart names none
DATE = "undated"  # the same chart must give the same bytes on every day


@dataclass(frozen=True)
class ManifestParameter:
    """A parameter that a behavior offers: `kind` is enum, numeric, boolean, text or yaml."""

    name: str
    kind: str


@dataclass(frozen=True)
class Manifest:
    """What the manifest of a behavior states.

    Attributes:
        name: display name, the key of the behavior everywhere.
        package: ROS package and Python package.
        module: module below the package, dotted if it lies deeper.
        contains: display names of the behaviors used in it.
        parameters: read only; behaviors made from charts have none.
    """

    name: str
    package: str
    module: str
    class_name: str
    contains: tuple[str, ...] = ()
    parameters: tuple[ManifestParameter, ...] = ()


def read_manifest(text: str | bytes, file: str) -> Manifest | None:
    """Return the manifest that the text holds, None if it is XML of another kind or no XML."""
    try:
        if read_root(as_utf8(text, file))[0] != "behavior":
            return None  # a chart, for one, which may be large
        root = XmlTree(text, file).root
    except ChartError:
        return None
    executable = root.find("executable")
    if executable is None:
        return None
    package, _, module = executable.get("package_path", "").partition(".")
    if not package or not module or "/" in module:
        return None
    return Manifest(
        name=root.get("name", ""),
        package=package,
        module=module,
        class_name=executable.get("class", ""),
        contains=tuple(contained.get("name", "") for contained in root.iterfind("contains")),
        parameters=tuple(
            ManifestParameter(param.get("name", ""), param.get("type", ""))
            for param in root.iterfind("params/param")
        ),
    )


def write_manifest(manifest: Manifest, description: str, author: str = "", tags: str = "") -> str:
    """Return the manifest's text, in the order in which the FlexBE App writes it."""
    contains = "".join(f"\t<contains name={_quoted(name)} />\n" for name in manifest.contains)
    return f"""<?xml version="1.0" encoding="UTF-8"?>

<behavior name={_quoted(manifest.name)}>

\t<executable package_path={_quoted(f"{manifest.package}.{manifest.module}")} \
class={_quoted(manifest.class_name)} />
\t<tagstring>{html.escape(tags, quote=False)}</tagstring>
\t<author>{html.escape(author or AUTHOR, quote=False)}</author>
\t<date>{DATE}</date>
\t<description>
\t\t{html.escape(description, quote=False)}
\t</description>


\t<!-- Contained Behaviors -->
{contains}
\t<!-- Available Parameters -->

</behavior>"""


def _quoted(value: str) -> str:
    return f'"{html.escape(value)}"'


_MARK = re.compile(r"^\s*(--|>#|#>)\s+(\S+)[ \t]+(\S+)", re.MULTILINE)
_OUTCOME = re.compile(r"^\s*<=\s+(.*?)(?=^\s*(?:--|>#|#>|<=)\s|\Z)", re.MULTILINE | re.DOTALL)
_ARGUMENT = re.compile(r"^\s*--\s+(\S+)(.*?)(?=^\s*(?:--|>#|#>|<=)\s|\Z)", re.MULTILINE | re.DOTALL)
_GRACE = re.compile(r"\[grace\s+([^\]]*)\]")
_SECONDS = re.compile(r"(\d+(?:\.\d+)?) s")
_WRITES = re.compile(r"\[writes\s+([^\]]*)\]")
_CANCELS = {"cancel", "cancel_goal", "cancel_all_goals"}


class _UnreadableError(ValueError):
    """The class is outside what can be read from text."""


def read_state_class(text: str, package: str, module: str) -> StateClass | Unreadable | None:
    """Return the first state class of a file, why it cannot be used, or None if it has none.

    Raises:
        SyntaxError: if the text is not Python.
    """
    classes = (node for node in ast.parse(text).body if isinstance(node, ast.ClassDef))
    found = next((c for c in classes if [*map(ast.unparse, c.bases)] == ["EventState"]), None)
    if found is None:
        return None
    try:
        return _read_class(found, package, module)
    except _UnreadableError as error:
        return Unreadable(found.name, package, str(error))


def _expect_importable(module: str) -> None:
    """Refuse a module that no behavior can import, since a name on the way is none in Python."""
    parts = module.split(".")
    if not all(part.isidentifier() and not keyword.iskeyword(part) for part in parts):
        raise _UnreadableError(f"Python cannot import its module {module}; rename its file")


def _read_class(found: ast.ClassDef, package: str, module: str) -> StateClass:
    _expect_importable(module)
    constructor = _constructor(found)
    docstring = ast.get_docstring(found) or ""
    documented = {
        (mark, name): documented_type(kind) for mark, name, kind in _MARK.findall(docstring)
    }
    parameters = tuple(_parameters(constructor, documented, _graces(docstring)))
    known = {parameter.name for parameter in parameters}
    lists = {
        given.arg: _name_list(given.arg, given.value, known)
        for given in _super_call(constructor).keywords
        if given.arg in ("outcomes", "input_keys", "output_keys", "io_keys")
    }
    outcomes = lists.get("outcomes", ())
    if not outcomes:
        raise _UnreadableError(
            "its constructor declares no outcomes; a state that monitors until its container ends "
            "needs one, too, which it never returns"
        )
    for outcome in () if isinstance(outcomes, FromParameter) else outcomes:
        if not names.is_readable_outcome(outcome):
            raise _UnreadableError(f"the FlexBE App cannot read its outcome {outcome!r}")
    outputs = _ports(lists.get("output_keys", ()), lists.get("io_keys", ()), "#>", documented)
    return StateClass(
        name=found.name,
        package=package,
        module=module,
        parameters=parameters,
        outcomes=outcomes,
        inputs=_ports(lists.get("input_keys", ()), lists.get("io_keys", ()), ">#", documented),
        outputs=outputs,
        leaves_goals=_leaves_goals(found),
        effects=tuple(_effects(docstring, outcomes, outputs)),
    )


def _effects(
    docstring: str,
    outcomes: tuple[str, ...] | FromParameter,
    outputs: tuple[Port, ...] | FromParameter,
) -> Iterator[Effect]:
    """Yield what outcomes write, as far as the docstring limits it."""
    if isinstance(outcomes, FromParameter) or isinstance(outputs, FromParameter):
        return
    keys = {port.name for port in outputs}
    for text in _OUTCOME.findall(docstring):
        written = _WRITES.search(text)
        if written is None:
            continue
        named = (o for o in outcomes if re.match(re.escape(o) + r"(\s|\Z)", text))
        outcome = max(named, key=len, default=None)
        if outcome is None:
            raise _UnreadableError(
                f"its docstring has no outcome of its own at '<= {text.strip()}'"
            )
        found = frozenset(filter(None, re.split(r"[,\s]+", written[1]))) - {"nothing"}
        if not found <= keys:
            unknown = names.quoted(sorted(found - keys))
            raise _UnreadableError(
                f"its docstring lets '{outcome}' write {unknown}, and its outputs are "
                f"{names.quoted(sorted(keys))}"
            )
        yield Effect(outcome, found, found)


def _leaves_goals(found: ast.ClassDef) -> bool:
    """Return whether a class calls `send_goal` and none of the calls that cancel a goal."""
    called = {
        node.func.attr
        for node in ast.walk(found)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
    }
    return "send_goal" in called and not called & _CANCELS


def _constructor(found: ast.ClassDef) -> ast.FunctionDef:
    for node in found.body:
        if isinstance(node, ast.FunctionDef) and node.name == "__init__":
            return node
    raise _UnreadableError("it has no __init__ that declares its outcomes")


def _graces(docstring: str) -> Mapping[str, float]:
    """Return how long a visit may last beyond the time limits that the arguments are [s]."""
    graces = {}
    for name, text in _ARGUMENT.findall(docstring):
        if declared := _GRACE.search(text):
            seconds = _SECONDS.fullmatch(declared[1].strip())
            if seconds is None:
                raise _UnreadableError(
                    f"its docstring has '{declared[0]}' at '-- {name}'; allowed: seconds such as "
                    "[grace 2 s]"
                )
            graces[name] = float(seconds[1])
    return graces


def _parameters(
    constructor: ast.FunctionDef,
    documented: Mapping[tuple[str, str], str | None],
    graces: Mapping[str, float],
) -> Iterator[Parameter]:
    """Yield the constructor's arguments after self."""
    given = constructor.args
    positional = [*given.posonlyargs, *given.args][1:]
    first_default = len(positional) - len(given.defaults)
    defaults = [*[None] * first_default, *given.defaults, *given.kw_defaults]
    for argument, default in zip([*positional, *given.kwonlyargs], defaults, strict=True):
        annotation = documented_type(ast.unparse(argument.annotation or ast.Constant("")))
        kind = documented.get(("--", argument.arg)) or annotation
        if ("--", argument.arg) not in documented and argument.annotation is None:
            kind = "string" if _is_text(default) else None
        grace_s = graces.get(argument.arg, 0.0)
        yield Parameter(
            argument.arg,
            kind,
            default is None,
            _number(default),
            grace_s,
            default_source=_literal_source(default),
        )


def _is_text(node: ast.expr | None) -> bool:
    """Return whether a default is a string."""
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


def _literal_source(node: ast.expr | None) -> str:
    """Return the source of a literal as behaviors hold it; empty for anything else."""
    try:
        return python_literal(freeze(ast.literal_eval(node))) if node is not None else ""
    except (ValueError, TypeError):
        return ""


def _number(node: ast.expr | None) -> float | None:
    """Return the number that a default is, None for any other, and for one beyond all floats."""
    value = node.value if isinstance(node, ast.Constant) else None
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    return value if abs(value) <= sys.float_info.max else None


def _super_call(constructor: ast.FunctionDef) -> ast.Call:
    for node in ast.walk(constructor):
        if (
            isinstance(node, ast.Call)
            and isinstance(node.func, ast.Attribute)
            and node.func.attr == "__init__"
            and isinstance(node.func.value, ast.Call)
            and isinstance(node.func.value.func, ast.Name)
            and node.func.value.func.id == "super"
        ):
            return node
    raise _UnreadableError("its constructor does not call super().__init__(outcomes=[...])")


def _name_list(name: str, value: ast.expr, parameters: set[str]) -> tuple[str, ...] | FromParameter:
    if isinstance(value, ast.Name) and value.id in parameters:
        return FromParameter(value.id)
    if isinstance(value, ast.List):
        items = [item.value for item in value.elts if isinstance(item, ast.Constant)]
        texts = [item for item in items if isinstance(item, str)]
        if len(texts) == len(value.elts):
            return tuple(dict.fromkeys(texts))
    raise _UnreadableError(
        f"its {name} are {ast.unparse(value)}; only a list of strings or a constructor argument "
        "can be read without running it"
    )


def _ports(
    keys: tuple[str, ...] | FromParameter,
    both: tuple[str, ...] | FromParameter,
    mark: str,
    documented: Mapping[tuple[str, str], str | None],
) -> tuple[Port, ...] | FromParameter:
    """Return the keys of one direction, with those of both directions after them."""
    if isinstance(keys, FromParameter) and not both:
        return keys
    if isinstance(both, FromParameter) and not keys:
        return both
    if isinstance(keys, FromParameter) or isinstance(both, FromParameter):
        raise _UnreadableError("its io_keys stand beside keys taken from an argument")
    return tuple(Port(key, documented.get((mark, key))) for key in dict.fromkeys((*keys, *both)))


# Read a behavior's interface from the text of its file; nothing is imported.
#
# The file is laid out as the FlexBE App writes it: `add_parameter` in `__init__`, and in `create` a
# root container with keyword arguments, its default userdata, and a `return` of it.


_CONTAINERS = ("OperatableStateMachine", "ConcurrencyContainer", "PriorityContainer")
_KINDS = {"numeric": "float", "boolean": "bool", "text": "string", "enum": "string"}


def read_behavior_class(text: str, manifest: Manifest) -> BehaviorClass | Unreadable:
    """Return the interface of the behavior that a manifest names, or why it cannot be read."""
    try:
        return _read_behavior_class(ast.parse(text), manifest)
    except (SyntaxError, ValueError, TypeError, RecursionError, MemoryError) as error:
        reason = str(error) or "its code is nested too deeply"
        return Unreadable(manifest.name, manifest.package, reason, manifest.class_name)


def _read_behavior_class(tree: ast.Module, manifest: Manifest) -> BehaviorClass:
    _expect_importable(f"{manifest.package}.{manifest.module}")
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
            if not node.args:
                raise ValueError(f"{ast.unparse(node)} does not begin with the parameter's name")
            yield str(ast.literal_eval(node.args[0]))


def _strings(value: ast.expr | None) -> tuple[str, ...]:
    found = () if value is None else ast.literal_eval(value)
    if not isinstance(found, list | tuple):
        raise ValueError(f"{found!r} is no list of names")
    return tuple(map(str, found))


def _is_none(value: ast.expr | None) -> bool:
    return value is None or (isinstance(value, ast.Constant) and value.value is None)
