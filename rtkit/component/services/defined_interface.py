"""Makes service interfaces from the IDL definitions that service ports give."""

from __future__ import annotations

import inspect
import re
from collections.abc import Mapping
from functools import cache
from typing import Any, NamedTuple

from rtkit.component.services.interface import Interface, raises, returns
from rtkit.component.values.defined import DefinedTypes
from rtkit.errors import NotFound, Refused
from rtkit.idl.model import Definitions, Direction, Operation, StructDeclaration
from rtkit.idl.read import read_idl
from rtkit.rtc.profiles import operations_in


class DefinedOperation(NamedTuple):
    """An operation of an interface.

    Attributes:
        returned: Names of the values that its method returns; that of the result is empty.
        text: Its declaration.
    """

    name: str
    returned: tuple[str, ...]
    text: str


class DefinedInterface(NamedTuple):
    """An interface and its operations by name."""

    interface: Interface
    operations: Mapping[str, DefinedOperation]


class RaisedByProvider(Refused):
    """An exception that an operation declares, and a provider raised, with what it carries."""

    def __init__(self, **members: Any) -> None:
        super().__init__(", ".join(f"{name}={value!r}" for name, value in members.items()))
        self.members = members


@cache
def interface_of(name: str, definition: str) -> DefinedInterface:
    """Return the interface of that name, ``SimpleService::MyService``, that a definition has.

    Raises:
        NotFound: The definition has no such interface, or one without operations.
        Malformed: It cannot be read.
    """
    definitions = read_idl(definition, name)
    declared = definitions.interface(name)
    if declared is None or not declared.operations:
        raise NotFound(f"no operations of {name} are known")
    maker = DefinedTypes(definitions)
    methods = {each.name: method_of(each, definitions, maker) for each in declared.operations}
    interface = Interface(type(declared.path[-1], (), methods), name)
    own = re.search(rf"interface _?{declared.path[-1]} {{\n(?s:.*?)\n  }};", definition)
    texts = dict(operations_in(own[0] if own else ""))
    operations = {
        each.name: DefinedOperation(each.name, _returned(each), texts.get(each.name, each.name))
        for each in declared.operations
    }
    return DefinedInterface(interface, operations)


def method_of(operation: Operation, definitions: Definitions, maker: DefinedTypes) -> Any:
    """Return a function that does nothing, of the signature of an operation."""

    def method() -> None:
        return None

    given = [each for each in operation.parameters if each.direction is not Direction.OUT]
    kinds = [] if operation.result is None else [operation.result]
    kinds += [each.type for each in operation.parameters if each.direction is not Direction.IN]
    back = [maker.hint(each) for each in kinds]
    result = tuple[tuple(back)] if len(back) > 1 else back[0] if back else type(None)  # type: ignore[misc]
    _shape(method, {each.name: maker.hint(each.type) for each in given}, result)
    method.__name__ = operation.name
    declared = [_exception(definitions.by_path[path], maker) for path in operation.raises]
    return raises(*declared)(returns(*_returned(operation))(method))


def _exception(declared: Any, maker: DefinedTypes) -> type[Exception]:
    assert isinstance(declared, StructDeclaration)

    def begin(self: Any, **members: Any) -> None:
        RaisedByProvider.__init__(self, **members)
        vars(self).update(members)

    _shape(begin, {each.name: maker.hint(each.type) for each in declared.fields}, None)
    return type(declared.path[-1], (RaisedByProvider,), {"__init__": begin})


def _shape(function: Any, parameters: Mapping[str, Any], result: Any) -> None:
    """Have a function tell these parameters, and what it returns."""
    kind = inspect.Parameter.POSITIONAL_OR_KEYWORD
    names = [inspect.Parameter(name, kind) for name in ("self", *parameters)]
    function.__signature__ = inspect.Signature(names)
    function.__annotations__ = {**parameters, "return": result}


def _returned(operation: Operation) -> tuple[str, ...]:
    back = [each.name for each in operation.parameters if each.direction is not Direction.IN]
    return (*([] if operation.result is None else [""]), *back)
