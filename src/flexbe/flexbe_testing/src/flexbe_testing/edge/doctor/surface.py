"""What flexbe_core of this engine has, read from its source."""

from __future__ import annotations

import ast
import importlib.util
from functools import cache
from pathlib import Path


@cache
def names_of(module: str) -> frozenset[str] | None:
    """Return the names that a module of flexbe_core binds; None if there is no such module."""
    file = _file(module)
    if file is None:
        return None
    names: set[str] = set()
    for node in ast.parse(file.read_text()).body:
        names |= _bound(node)
    return frozenset(names)


@cache
def attributes() -> frozenset[str]:
    """Return the names that states and containers of this engine have, methods included."""
    names: set[str] = set()
    for file in (_root() / "core").glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.ClassDef):
                for item in node.body:
                    names |= _bound(item)
            elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
                names.add(node.attr)
    return frozenset(names)


@cache
def _root() -> Path:
    spec = importlib.util.find_spec("flexbe_core")
    if spec is None or spec.origin is None:
        raise ImportError("flexbe_core is not on PYTHONPATH; source the workspace's setup.sh")
    return _source(Path(spec.origin)).parent


def _source(file: Path) -> Path:
    """Return the file that a stub in catkin's devel space stands for; the file itself if none."""
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Constant) and str(node.value).startswith("/"):
            source = Path(str(node.value)) / "flexbe_core" / "__init__.py"
            if source.is_file():
                return source
    return file


def _file(module: str) -> Path | None:
    path = _root().joinpath(*module.split(".")[1:])
    for file in (path / "__init__.py", path.with_suffix(".py")):
        if file.is_file():
            return file
    return None


def _bound(node: ast.stmt) -> set[str]:
    if isinstance(node, ast.Import | ast.ImportFrom):
        return {alias.asname or alias.name.split(".")[0] for alias in node.names}
    if isinstance(node, ast.FunctionDef | ast.ClassDef):
        return {node.name}
    targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
    return {target.id for target in targets if isinstance(target, ast.Name)}
