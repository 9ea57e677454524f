"""Read a behavior's file back as the machine that it was rendered from; nothing is imported.

The file is laid out as `render_python` or the FlexBE App writes it. What a machine cannot hold,
such as custom code, is reported, all at once, each with its line.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping

from flexbe_synthesizer.core.chart.model import Autonomy, freeze
from flexbe_synthesizer.core.library.signature import BehaviorClass, Library, StateClass
from flexbe_synthesizer.core.library.sources import AUTHOR
from flexbe_synthesizer.core.machine.machine import (
    BehaviorUse,
    Child,
    Condition,
    Container,
    Exit,
    Expression,
    Kind,
    Machine,
    Pair,
    StateUse,
    Value,
)

_KINDS = {kind.value: kind for kind in Kind}
_CONSTRUCTION = ("super(", "self.add_behavior(")
_ADDED_WITH = ("transitions", "autonomy", "remapping")  # of `add`, after label and state
_LEVELS = {level.value.capitalize(): level for level in Autonomy}


class InexpressibleError(ValueError):
    """A behavior holds what a chart cannot say; `reasons` has a line for each."""

    def __init__(self, reasons: tuple[str, ...]) -> None:
        """Keep the reasons; the message is their lines."""
        self.reasons = reasons
        super().__init__("\n".join(reasons))


def read_machine(text: str, file: str, library: Library, *, is_outline: bool = False) -> Machine:
    """Return the machine that a behavior's file holds.

    Args:
        text: of the file.
        file: what to call it in messages.
        library: has its states and behaviors.
        is_outline: leave out what does not change which states there are, where they lead and what
            they read and write: parameters of the behavior, methods, values that are no literals.

    Raises:
        InexpressibleError: if it is no behavior, or holds what a machine cannot.
    """
    try:
        tree = ast.parse(text)
        reader = _Reader(file, library, dict(_imports(tree)))
        reader.refuse_manual_sections(text)
        machine = reader.machine(tree)
    except SyntaxError as error:
        raise InexpressibleError(
            (f"{file}:{error.lineno or 1}: not Python: {error.msg}",)
        ) from error
    except ValueError as error:
        raise InexpressibleError((f"{file}:1: not Python: {error}",)) from error
    except (RecursionError, MemoryError) as error:
        raise InexpressibleError(
            (f"{file}:1: code that is nested too deeply to be read",)
        ) from error
    if machine is None or (reader.reasons and not is_outline):
        raise InexpressibleError(tuple(reader.reasons))
    if reader.breaks:
        raise InexpressibleError(tuple(reader.breaks))
    return machine


def _imports(tree: ast.Module) -> Iterator[tuple[str, tuple[str, str]]]:
    """Yield what each imported name is: its module and its name there."""
    for node in tree.body:
        if isinstance(node, ast.ImportFrom) and node.module:
            for alias in node.names:
                yield alias.asname or alias.name, (node.module, alias.name)


class _Reader:
    """Reads one file, and collects what cannot be read."""

    def __init__(self, file: str, library: Library, imports: Mapping[str, tuple[str, str]]) -> None:
        self._file = file
        self._library = library
        self._imports = imports
        self._containers: dict[str, ast.Call] = {}
        self._blocks: dict[str, list[ast.Call]] = {}
        self._inside: list[str] = []  # variables of the containers around what is being read
        self._manual_lines: set[int] = set()
        self.reasons: list[str] = []
        self.breaks: list[str] = []  # of the reasons those without which there is no outline

    def _refuse(self, node: ast.AST, reason: str, *, is_detail: bool = False) -> None:
        line = getattr(node, "lineno", 1)
        if not is_detail:
            self.breaks.append(f"{self._file}:{line}: {reason}")
        if line not in self._manual_lines:  # which are reported as a section
            self.reasons.append(f"{self._file}:{line}: {reason}")

    def _refuse_statement(self, node: ast.AST, *, is_detail: bool = False) -> None:
        reason = f"a custom statement: {ast.unparse(node).splitlines()[0]}"
        self._refuse(node, reason, is_detail=is_detail)

    def refuse_manual_sections(self, text: str) -> None:
        try:
            sections = read_manual_sections(text)
        except ManualSectionError:
            return  # written by hand altogether; the manual sections do not matter then
        for name, content in sections.items():
            if content.strip():
                line = text[: text.index(f"# [MANUAL_{name}]")].count("\n") + 1
                self._manual_lines |= set(range(line, line + content.count("\n") + 1))
                reason = f"custom code in MANUAL_{name}, which a chart cannot carry"
                self.reasons.append(f"{self._file}:{line}: {reason}")

    def machine(self, tree: ast.Module) -> Machine | None:
        classes = [c for c in tree.body if isinstance(c, ast.ClassDef)]
        found = next((c for c in classes if [*map(ast.unparse, c.bases)] == ["Behavior"]), None)
        methods = {m.name: m for m in found.body if isinstance(m, ast.FunctionDef)} if found else {}
        for node in (*tree.body, *(found.body if found else ())):
            is_layout = isinstance(node, ast.Import | ast.ImportFrom) or _is_text(node)
            if not is_layout and node is not found and node not in methods.values():
                self._refuse_statement(node, is_detail=True)
        for method in methods.values():
            if method.name not in ("__init__", "create"):
                self._refuse(method, f"a custom method: {method.name}", is_detail=True)
        if found is None or not {"__init__", "create"} <= methods.keys():
            self._refuse(tree, "no class (Behavior) with __init__ and create")
            return None
        name = self._name(methods["__init__"])
        root, userdata = self._scan(methods["create"])
        if root is None or name is None:
            return None
        container = self._container(root, userdata)
        description = ast.get_docstring(found) or ""
        return Machine(name, "", description, container, _author(tree))

    def _name(self, constructor: ast.FunctionDef) -> str | None:
        """Return the display name; refuse parameters, which charts do not have."""
        name = None
        for node in constructor.body:
            if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "self.name":
                name = self._literal(node.value, "self.name")
            elif isinstance(node, ast.Expr) and ast.unparse(node).startswith("self.add_parameter"):
                parameter = f"a parameter of the behavior: {ast.unparse(node)}"
                self._refuse(node, parameter, is_detail=True)
            elif not _is_text(node) and not ast.unparse(node).startswith(_CONSTRUCTION):
                self._refuse_statement(node, is_detail=True)
        if not isinstance(name, str):
            self._refuse(constructor, "no self.name")
            return None
        return name

    def _scan(self, create: ast.FunctionDef) -> tuple[str | None, tuple[Pair, ...]]:
        """Sort the statements of create; return the root's variable and the default userdata."""
        userdata: list[Pair] = []
        root = None
        for node in create.body:
            if isinstance(node, ast.Return) and isinstance(node.value, ast.Name):
                root = node.value.id
            elif isinstance(node, ast.With):
                self._blocks[ast.unparse(node.items[0].context_expr)] = adds = []
                for inner in node.body:
                    if isinstance(inner, ast.Expr) and isinstance(inner.value, ast.Call):
                        adds.append(inner.value)
                    else:
                        self._refuse_statement(inner)
            elif isinstance(node, ast.Assign) and (call := _container_call(node)) is not None:
                self._containers[ast.unparse(node.targets[0])] = call
            elif isinstance(node, ast.Assign) and ".userdata." in ast.unparse(node.targets[0]):
                key = ast.unparse(node.targets[0]).rpartition(".")[2]
                userdata.append(Pair(key, self._value(node.value, f"default of '{key}'")))
            elif not _is_text(node):
                self._refuse_statement(node, is_detail=self._is_value(node))
        if root not in self._containers:
            self._refuse(create, "create does not return a container")
            return None, ()
        return root, tuple(userdata)

    def _is_value(self, node: ast.stmt) -> bool:
        """Return whether a statement of create only assigns a value to a name."""
        return isinstance(node, ast.Assign) and all(
            isinstance(target, ast.Name) and target.id not in self._containers
            for target in node.targets
        )

    def _value(self, node: ast.expr, what: str, *, is_detail: bool = True) -> Value:
        """Return a value; an expression is kept as text if it is a function."""
        try:
            return freeze(ast.literal_eval(node))
        except (ValueError, TypeError, RecursionError):
            if isinstance(node, ast.Lambda):
                return Expression(ast.unparse(node))
            self._refuse(node, f"{what} is no literal: {ast.unparse(node)}", is_detail=is_detail)
            return None

    def _literal(self, node: ast.expr, what: str) -> object:
        """Return the value of a literal; refuse anything else."""
        try:
            return ast.literal_eval(node)
        except (ValueError, TypeError):
            self._refuse(node, f"{what} is no literal: {ast.unparse(node)}")
            return None

    def _names(self, node: ast.expr | None, what: str) -> tuple[str, ...]:
        """Return a list of names."""
        found = () if node is None else self._literal(node, what)
        return tuple(map(str, found)) if isinstance(found, list | tuple) else ()

    def _map(self, node: ast.expr | None, what: str) -> dict[str, str]:
        """Return a dictionary of names."""
        found = None if node is None else self._literal(node, what)
        return {str(k): str(v) for k, v in found.items()} if isinstance(found, dict) else {}

    def _conditions(self, node: ast.expr | None) -> Iterator[Condition]:
        """Yield what a concurrency container ends with."""
        found = None if node is None else self._literal(node, "conditions")
        for item in found if isinstance(found, list | tuple) else ():
            match item:
                case (outcome, [*pairs]) if all(
                    isinstance(p, tuple) and len(p) == 2 for p in pairs
                ):
                    yield Condition(str(outcome), tuple((str(s), str(o)) for s, o in pairs))
                case _ if node is not None:
                    self._refuse(
                        node, f"a condition that is not (outcome, [(state, outcome)]): {item}"
                    )

    def _container(self, variable: str, userdata: tuple[Pair, ...] = ()) -> Container:
        call, adds = self._containers[variable], self._blocks.get(variable, [])
        given = {k.arg: k.value for k in call.keywords}
        self._inside.append(variable)
        children = tuple(child for add in adds if (child := self._child(add)) is not None)
        self._inside.pop()
        if not adds:
            self._refuse(call, f"{variable} is a container without states")
        return Container(
            _KINDS[ast.unparse(call.func)],
            self._names(given.get("outcomes"), "outcomes"),
            input_keys=self._names(given.get("input_keys"), "input_keys"),
            output_keys=self._names(given.get("output_keys"), "output_keys"),
            children=children,
            userdata=userdata,
            conditions=tuple(self._conditions(given.get("conditions"))),
        )

    def _child(self, add: ast.Call) -> Child | None:
        if ast.unparse(add.func) != "OperatableStateMachine.add" or len(add.args) < 2:
            self._refuse(add, f"a custom call: {ast.unparse(add).splitlines()[0]}")
            return None
        given: dict[str | None, ast.expr] = dict(zip(_ADDED_WITH, add.args[2:], strict=False))
        given |= {k.arg: k.value for k in add.keywords}
        label = self._literal(add.args[0], "the label of a state")
        if not isinstance(label, str):
            return None
        content = self._content(add.args[1], label)
        if content is None:
            return None
        targets = self._map(given.get("transitions"), f"transitions of '{label}'")
        levels = dict(_levels(given.get("autonomy"), isinstance(content, StateUse)))
        homes = self._map(given.get("remapping"), f"remapping of '{label}'")
        exits = tuple(Exit(o, target, levels.get(o)) for o, target in targets.items())
        return Child(label, content, exits, tuple(homes.items()))

    def _content(self, node: ast.expr, label: str) -> StateUse | BehaviorUse | Container | None:
        """Return what a child is."""
        if isinstance(node, ast.Name) and node.id in self._inside:
            self._refuse(node, f"'{label}' is a container that it lies in itself")
            return None
        if isinstance(node, ast.Name) and node.id in self._containers:
            return self._container(node.id)
        if not isinstance(node, ast.Call):
            self._refuse(node, f"'{label}' is neither a state, a behavior nor a container")
            return None
        if ast.unparse(node.func) == "self.use_behavior":
            return self._behavior(node, label)
        alias = ast.unparse(node.func)
        module, name = self._imports.get(alias, ("", alias))
        found = [s for s in self._library.find_states(f"{module.split('.')[0]}/{name}")]
        if len(found) != 1 or not isinstance(found[0], StateClass) or node.args:
            self._refuse(node, f"'{label}' is of the class {alias}, whose arguments cannot be read")
            return None
        deciding = found[0].deciding_parameters
        pairs = tuple(
            Pair(
                str(k.arg),
                self._value(k.value, f"'{k.arg}' of '{label}'", is_detail=k.arg not in deciding),
            )
            for k in node.keywords
        )
        return StateUse(found[0], alias, pairs)

    def _behavior(self, node: ast.Call, label: str) -> BehaviorUse | None:
        alias = ast.unparse(node.args[0]) if node.args else ""
        found = [b for b in self._library.find_behaviors(alias) if isinstance(b, BehaviorClass)]
        if len(found) != 1:
            self._refuse(node, f"'{label}' is of the behavior class {alias}, which is not found")
            return None
        given = {k.arg: k.value for k in node.keywords}
        parameters: list[Pair] = []
        listed = given.get("parameters")
        if isinstance(listed, ast.Dict):
            for key, value in zip(listed.keys, listed.values, strict=True):
                name = str(self._literal(key or ast.Constant(""), "the name of a parameter"))
                parameters.append(Pair(name, self._value(value, f"'{name}' of '{label}'")))
        kept = self._names(given.get("default_keys"), "default_keys")
        return BehaviorUse(found[0], tuple(parameters), kept)


def _author(tree: ast.Module) -> str:
    """Return who wrote a behavior; empty if its file does not say."""
    values = (node.value for node in tree.body if isinstance(node, ast.Expr))
    texts = (one.value for one in values if isinstance(one, ast.Constant))
    lines = (line for text in texts if isinstance(text, str) for line in text.splitlines())
    found = (line.removeprefix("@author:").strip() for line in lines if line[:8] == "@author:")
    author = next(found, "")
    return "" if author == AUTHOR else author


def _is_text(node: ast.AST) -> bool:
    """Return whether a statement is a docstring or `pass`."""
    is_text = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    return is_text or isinstance(node, ast.Pass)


def _container_call(node: ast.Assign) -> ast.Call | None:
    """Return the call that makes the container which is assigned, None if it is something else."""
    call = node.value
    return call if isinstance(call, ast.Call) and ast.unparse(call.func) in _KINDS else None


def _levels(node: ast.expr | None, is_state: bool) -> Iterator[tuple[str, Autonomy]]:
    """Yield the levels of autonomy that are not the default of their kind."""
    if not isinstance(node, ast.Dict):
        return
    for key, value in zip(node.keys, node.values, strict=True):
        word = ast.unparse(value).rpartition(".")[2]
        if key is not None and word in _LEVELS and not (is_state and word == "Off"):
            yield str(getattr(key, "value", key)), _LEVELS[word]


# The sections of a behavior file that belong to the person who edits it, not to the generator


_NAME = re.compile(r"^ +self\.name = (.+)$", re.MULTILINE)
SECTIONS = ("IMPORT", "INIT", "CREATE", "FUNC")


class ManualSectionError(ValueError):
    """A file has no sections that can be kept, so that writing it again would lose something."""


def read_manual_sections(text: str) -> Mapping[str, str]:
    """Return what stands between the tags of each section, to the byte.

    Raises:
        ManualSectionError: if the file has no tags, or a tag without its partner, or twice.
    """
    found: dict[str, str] = {}
    for section in SECTIONS:
        begin, end = f"# [MANUAL_{section}]", f"# [/MANUAL_{section}]"
        if (text.count(begin), text.count(end)) == (0, 0):
            continue
        before, _, rest = text.partition(begin)
        content, mark, after = rest.partition(end)
        if not mark or begin in after or end in before or end in after:
            raise ManualSectionError(
                f"'{begin}' and '{end}' do not appear once each, in this order; correct the tags, "
                "or move the file away"
            )
        found[section] = content
    if not found:
        raise ManualSectionError(
            "it has none of the tags that a generated behavior has, such as '# [MANUAL_INIT]', so "
            "it was written by hand; move it away, or rename the chart"
        )
    return found


def written_name(text: str) -> str | None:
    """Return the name of the behavior that a file says it is; None if it does not say it."""
    found = _NAME.search(text)
    try:
        name = ast.literal_eval(found[1]) if found else None
    except (SyntaxError, ValueError, TypeError, RecursionError, MemoryError):
        return None
    return name if isinstance(name, str) else None
