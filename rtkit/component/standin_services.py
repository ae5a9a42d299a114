"""Service ports of stand-ins that answer: each operation returns zero and empty values."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from rtkit.component.services.defined_interface import interface_of
from rtkit.component.services.interface import Interface, InterfaceMethod
from rtkit.component.services.service import ServicePort
from rtkit.component.values.type_layout import zero
from rtkit.errors import NotFound
from rtkit.rtc.enums import Polarity
from rtkit.rtc.profiles import PortInterfaceProfile, PortProfile


def answering(profile: PortProfile) -> ServicePort:
    """Return a port that provides the interfaces which its definition tells, and shows the others.

    Raises:
        Malformed: The definition cannot be read.
    """
    found = {each: _interface(each, profile.definition) for each in profile.interfaces}
    port = ServicePort(profile.name, tuple(each for each in found if found[each] is None))
    for each, interface in found.items():
        if interface is not None:
            done_by = SimpleNamespace(**{n: _zeros(m) for n, m in interface.methods.items()})
            port.provide(
                interface.cls, each.instance_name, implementation=done_by, type_name=each.type_name
            )
    return port


def _interface(profile: PortInterfaceProfile, definition: str) -> Interface | None:
    """Return an interface that is to be provided; None where its operations are not known."""
    if profile.polarity is Polarity.REQUIRED:
        return None
    try:
        return interface_of(profile.type_name, definition).interface
    except NotFound:
        return None


def _zeros(method: InterfaceMethod) -> Callable[..., Any]:
    _, layouts = method.results

    def answer(*_: Any) -> Any:
        values = tuple(map(zero, layouts))
        return values if len(values) > 1 else next(iter(values), None)

    return answer
