"""Read untrusted YAML with the line of every value; refuse aliases that grow without end."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import yaml

from remodel_production.errors import DesignError

# Values after all aliases are followed; a harness of 1000 connections has some ten thousand.
_MOST_VALUES = 200_000
# Composing recurses; a WireViz harness nests seven deep.
_MOST_DEPTH = 50
_MERGE = "tag:yaml.org,2002:merge"


@dataclass(frozen=True)
class Value:
    """A value of a document: a mapping, a list, or a scalar, and its line.

    Attributes:
        data: dict[str, Value], list[Value], or a scalar of YAML.
    """

    data: object
    line: int

    @property
    def where(self) -> str:
        """The place of the value, for errors."""
        return f"line {self.line}"

    def mapping(self, what: str) -> dict[str, Value]:
        """Return the entries; an empty value has none.

        Raises:
            DesignError: if this is no mapping.
        """
        if self.data is None:
            return {}
        if not isinstance(self.data, dict):
            raise DesignError(f"{self.where}: {what}: expected a mapping, found {self.shown}")
        return self.data

    def items(self, what: str) -> list[Value]:
        """Return the items; an empty value has none.

        Raises:
            DesignError: if this is no list.
        """
        if self.data is None:
            return []
        if not isinstance(self.data, list):
            raise DesignError(f"{self.where}: {what}: expected a list, found {self.shown}")
        return self.data

    @property
    def is_scalar(self) -> bool:
        """Return whether this is neither a mapping nor a list."""
        return not isinstance(self.data, dict | list)

    @property
    def text(self) -> str:
        """The scalar as text; empty for nothing."""
        return "" if self.data is None else str(self.data)

    @property
    def shown(self) -> str:
        """The value as an error shows it."""
        if isinstance(self.data, dict):
            return "a mapping"
        return "a list" if isinstance(self.data, list) else repr(self.data)[:60]


def parse_yaml(text: str) -> Value:
    """Return the document.

    Raises:
        DesignError: if it is no YAML, has keys twice, or grows without end by its aliases.
    """
    try:
        _refuse_deep(text)
        loader = yaml.CSafeLoader(text)
        try:
            node = loader.get_single_node()
            if node is None:
                return Value(None, 1)
            _refuse_endless(node)
            return _value(node, loader)
        finally:
            loader.dispose()
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = f"line {mark.line + 1}, column {mark.column + 1}: " if mark else ""
        raise DesignError(f"{where}is no YAML: {error.problem}") from error
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise DesignError(f"is no YAML: {' '.join(str(error).split())[:200]}") from error


def _refuse_deep(text: str) -> None:
    """Refuse a document that nests too deeply or is too long, before it is composed."""
    depth = 0
    for count, event in enumerate(yaml.parse(text, Loader=yaml.CSafeLoader)):
        if isinstance(event, yaml.CollectionStartEvent):
            depth += 1
        elif isinstance(event, yaml.CollectionEndEvent):
            depth -= 1
        if depth > _MOST_DEPTH or count > 2 * _MOST_VALUES:
            line = event.start_mark.line + 1
            found = f"{depth} levels" if depth > _MOST_DEPTH else f"{count} values"
            raise DesignError(
                f"line {line}: {found} found; at most {_MOST_DEPTH} levels and {_MOST_VALUES} "
                "values are read: split the file"
            )


def _children(node: yaml.Node) -> Iterator[yaml.Node]:
    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            yield key
            yield value
    elif isinstance(node, yaml.SequenceNode):
        yield from node.value


def _refuse_endless(root: yaml.Node) -> None:
    """Refuse a document that contains itself, or whose aliases multiply to too many values."""
    sizes: dict[int, int] = {}
    open_nodes: set[int] = set()
    stack: list[tuple[yaml.Node, bool]] = [(root, False)]
    while stack:
        node, is_done = stack.pop()
        if is_done:
            open_nodes.discard(id(node))
            sizes[id(node)] = 1 + sum(sizes[id(child)] for child in _children(node))
            if sizes[id(node)] > _MOST_VALUES:
                raise DesignError(
                    f"line {node.start_mark.line + 1}: more than {_MOST_VALUES} values, after its "
                    "aliases (*name) are followed: split the file, or remove aliases of aliases"
                )
        elif id(node) in open_nodes:
            raise DesignError(
                f"line {node.start_mark.line + 1}: the value contains itself by an alias (*name)"
            )
        elif id(node) not in sizes:
            open_nodes.add(id(node))
            stack.append((node, True))
            stack += [(child, False) for child in _children(node)]


def _value(node: yaml.Node, loader: yaml.CSafeLoader) -> Value:
    line = node.start_mark.line + 1
    if isinstance(node, yaml.MappingNode):
        return Value(_mapping(node, loader), line)
    if isinstance(node, yaml.SequenceNode):
        return Value([_value(item, loader) for item in node.value], line)
    return Value(loader.construct_object(node), line)


def _mapping(node: yaml.MappingNode, loader: yaml.CSafeLoader) -> dict[str, Value]:
    """Return the entries; the mapping's own replace those of merged mappings (<<)."""
    own: dict[str, Value] = {}
    merged: dict[str, Value] = {}
    for key_node, value_node in node.value:
        if key_node.tag == _MERGE:
            is_list = isinstance(value_node, yaml.SequenceNode)
            sources = value_node.value if is_list else [value_node]
            for source in sources:
                if not isinstance(source, yaml.MappingNode):
                    raise DesignError(
                        f"line {source.start_mark.line + 1}: << takes a mapping, or a list of them"
                    )
                merged = {**_mapping(source, loader), **merged}
            continue
        key, line = _value(key_node, loader), key_node.start_mark.line + 1
        if not key.is_scalar:
            raise DesignError(f"line {line}: a key must be a name, found {key.shown}")
        if key.text in own:
            raise DesignError(
                f"line {line}: key {key.text} is given before, at {own[key.text].where}: keep one"
            )
        own[key.text] = _value(value_node, loader)
    return {**merged, **own}
