"""Calls operations of IDL interfaces: mutable values and CORBA's exceptions on both sides.

Between them stand interfaces of rtkit, whose values are frozen: a servant does the operations of
one, and a proxy calls one.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from typing import Any

from rtkit.component.services.defined_interface import RaisedByProvider, method_of
from rtkit.component.services.interface import Interface, InterfaceMethod
from rtkit.component.services.service import ServicePort
from rtkit.component.values.type_layout import Layout
from rtkit.errors import Malformed, NotFound, RtkitError, Unreachable
from rtkit.idl.model import InterfaceDeclaration, Operation, Path
from rtkit.openrtm.corba.exceptions import SYSTEM_EXCEPTIONS, UserException
from rtkit.openrtm.corba.twins import UNFIT, freezer_of_layout, thawer_of_layout

Convert = Callable[[Any], Any]
_SYSTEM_EXCEPTION = re.compile(r" failed: ([A-Z_]+)\b")
"""The class of an exception in the words by which `rtkit.component.services.invocation` refuses."""


@cache
def interface_of(kind: Any) -> Interface:
    """Return rtkit's interface for the class of an IDL interface, inherited operations included.

    Raises:
        Malformed: An operation has what cannot be carried, or there is none.
    """
    declarations = kind.declarations
    methods = {
        each.name: method_of(each, declarations.definitions, declarations.types)
        for each in _operations(kind)
    }
    return Interface(type(kind.declared.path[-1], (), methods))


def _operations(kind: Any) -> Iterable[Operation]:
    by_path = kind.declarations.definitions.by_path

    def inherited(path: Path) -> Iterable[Operation]:
        declared = by_path.get(path)
        if isinstance(declared, InterfaceDeclaration):
            for base in declared.bases:
                yield from inherited(base)
            yield from declared.operations

    return inherited(kind.declared.path)


class ServantImplementation:
    """Does the operations of an interface of rtkit by a servant.

    Attributes:
        servant: The author's object.
    """

    def __init__(self, servant: Any, kind: Any) -> None:
        self.servant = servant
        for method in interface_of(kind).methods.values():
            setattr(self, method.name, _done_by(servant, method))


def _done_by(servant: Any, method: InterfaceMethod) -> Callable[..., Any]:
    thaw = [thawer_of_layout(each) for each in method.layouts.values()]
    give_back = _both(method, freezer_of_layout)
    raised = method.exception_classes

    def do(*arguments: Any) -> Any:
        function = getattr(servant, method.name, None)
        if function is None:
            raise SYSTEM_EXCEPTIONS["NO_IMPLEMENT"]()
        try:
            result = function(
                *(change(value) for change, value in zip(thaw, arguments, strict=True))
            )
        except UserException as error:
            name = type(error).__name__
            if name not in raised:
                raise
            members = _changed(vars(error), method.exceptions[name], freezer_of_layout)
            raise raised[name](**members) from error
        return give_back(result)

    do.__code__ = do.__code__.replace(co_name=method.name)
    return do


def proxy_class(kind: Any) -> type:
    """Return the class of references to objects elsewhere that have an interface."""
    calls = {name: _calling(each, kind) for name, each in interface_of(kind).methods.items()}
    return type(f"_objref_{kind.__name__}", (Proxy, kind), calls)


class Proxy:
    """A reference to the provider that a service port is connected with."""

    def __init__(self, port: ServicePort, interface: type) -> None:
        self._port = port
        self._interface = interface


def _calling(method: InterfaceMethod, kind: Any) -> Callable[..., Any]:
    freeze = [freezer_of_layout(each) for each in method.layouts.values()]
    give_back = _both(method, thawer_of_layout)

    def call(proxy: Any, *arguments: Any) -> Any:
        if len(arguments) != len(freeze):
            raise TypeError(f"{method.name} takes {len(freeze)} arguments, not {len(arguments)}")
        try:
            frozen = [change(value) for change, value in zip(freeze, arguments, strict=True)]
        except UNFIT as error:
            raise SYSTEM_EXCEPTIONS["BAD_PARAM"]() from error
        client: Any = proxy._port.client_of(proxy._interface)  # noqa: SLF001 - it is its method
        try:
            result = getattr(client, method.name)(*frozen)
        except RaisedByProvider as error:
            raise _exception(error, method, kind) from error
        except RtkitError as error:
            raise _system_exception(error) from error
        return give_back(result)

    call.__name__ = method.name
    return call


def _exception(error: RaisedByProvider, method: InterfaceMethod, kind: Any) -> BaseException:
    name = type(error).__name__
    for operation in _operations(kind):
        for path in operation.raises if operation.name == method.name else ():
            if path[-1] == name:
                members = _changed(error.members, method.exceptions[name], thawer_of_layout)
                made: BaseException = kind.declarations.value(path)(**members)
                return made
    return SYSTEM_EXCEPTIONS["UNKNOWN"]()


def _system_exception(error: RtkitError) -> BaseException:
    name = "UNKNOWN"
    if isinstance(error, Unreachable):
        name = "TRANSIENT" if "no provider" in str(error) else "COMM_FAILURE"
    elif isinstance(error, Malformed):
        name = "MARSHAL"
    elif isinstance(error, NotFound):
        name = "OBJECT_NOT_EXIST"
    elif (named := _SYSTEM_EXCEPTION.search(str(error))) and named[1] in SYSTEM_EXCEPTIONS:
        name = named[1]  # the servant has raised it
    return SYSTEM_EXCEPTIONS[name](why=str(error))


def _both(method: InterfaceMethod, converter_of: Callable[[Layout], Convert]) -> Convert:
    """Return the conversion of what an operation gives back: one value, several, or none."""
    _, layouts = method.results
    changes = [converter_of(each) for each in layouts]
    if not changes:
        return lambda result: None
    if len(changes) == 1:
        return changes[0]
    return lambda result: tuple(c(value) for c, value in zip(changes, result, strict=True))


def _changed(
    members: Mapping[str, Any],
    layouts: Mapping[str, Layout],
    converter_of: Callable[[Layout], Convert],
) -> dict[str, Any]:
    return {name: converter_of(layout)(members[name]) for name, layout in layouts.items()}
