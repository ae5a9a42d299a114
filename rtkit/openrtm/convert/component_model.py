"""Ports, parameters and bound data of a component, as its old source declares them."""

from __future__ import annotations

import ast
from dataclasses import dataclass, field
from typing import NamedTuple, TypeGuard

from rtkit.component.values.type_layout import Layout

Path = tuple[str, ...]
"""Fields from a value down to a part of it: ``("data", "vx")``."""


@dataclass
class OldPort:
    """A data port.

    Attributes:
        attribute: Of the old component: ``_xIn``.
        name: As others see it.
        kind: ``InPort`` or ``OutPort``.
        cls: Data type.
        bound: Attribute with the data that it is bound to; empty where there is none.
        doc: For users.
        properties: Texts that were given as its properties.
        native: Attribute of the native component.
    """

    attribute: str
    name: str
    kind: str
    cls: type
    bound: str
    doc: str = ""
    properties: dict[str, str] = field(default_factory=dict)
    native: str = ""


@dataclass
class OldParameter:
    """A configuration parameter.

    Attributes:
        attribute: Of the old component, a list of one value; empty where it is not bound.
        default: The value as Python source.
        extras: Further arguments of the native declaration, by name.
        is_list: Its value is a list of numbers there, a tuple in the native component.
        is_words: Its value is a list of texts there, one text with commas in the native one.
    """

    attribute: str
    name: str
    default: str
    extras: dict[str, str] = field(default_factory=dict)
    is_list: bool = False
    is_words: bool = False
    native: str = ""

    @property
    def value(self) -> str:
        """The expression of its value."""
        read = f"self.{self.native}"
        return f'[each.strip() for each in {read}.split(",")]' if self.is_words else read


class PartUse(NamedTuple):
    """A place at which a part of bound data is used.

    Attributes:
        node: The expression of that part.
        how: ``load``, ``store``, ``change`` (``+=``) or ``delete``.
    """

    node: ast.expr
    path: Path
    how: str


@dataclass
class BoundData:
    """A value that a port was bound to, an attribute of the old component.

    Attributes:
        initial: The call that made it.
        made_at: The statements that made it.
        accesses: Where parts of it are used; what only makes, stamps or writes it is none.
        stamps: Statements that set its time.
        writes: Calls that write it, with the port of each.
        rebound: Statements that put another value in its place.
    """

    attribute: str
    cls: type
    layout: Layout
    initial: ast.Call | None
    made_at: list[ast.stmt] = field(default_factory=list)
    accesses: list[PartUse] = field(default_factory=list)
    stamps: list[ast.Expr] = field(default_factory=list)
    writes: list[tuple[ast.Call, OldPort]] = field(default_factory=list)
    rebound: list[ast.stmt] = field(default_factory=list)
    port_name: str = ""


@dataclass
class OldComponent:
    """A component class of the old kind; or a function or class beside one, without ports."""

    node: ast.ClassDef | ast.FunctionDef
    spec: dict[str, str]
    ports: dict[str, OldPort] = field(default_factory=dict)
    parameters: dict[str, OldParameter] = field(default_factory=dict)
    unbound: list[OldParameter] = field(default_factory=list)
    data: dict[str, BoundData] = field(default_factory=dict)
    own_names: set[str] = field(default_factory=set)

    @property
    def methods(self) -> list[ast.FunctionDef]:
        """The methods of its class."""
        return [each for each in self.node.body if isinstance(each, ast.FunctionDef)]


def is_self(node: ast.AST, attribute: str = "") -> TypeGuard[ast.Attribute]:
    """Return whether an expression is an attribute of the object itself, or that one."""
    return (
        isinstance(node, ast.Attribute)
        and isinstance(node.value, ast.Name)
        and node.value.id == "self"
        and attribute in ("", node.attr)
    )


def text_of(node: ast.AST | None) -> str | None:
    """Return the text that a literal stands for; None where it is no text."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    return None
