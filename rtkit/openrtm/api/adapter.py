"""Components of rtkit that hold an object of a component class written for OpenRTM-aist.

The object does not become a component itself: its class has private and public names that would
collide. Ports, configuration and contexts are those of the holder; callbacks go to the object.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextvars import ContextVar
from typing import Any, ClassVar
from weakref import WeakSet

from rtkit.component.base import ACTIVE_SET, Component
from rtkit.component.configuration.config import DEFAULT, Configuration
from rtkit.component.configuration.parameter import Parameter
from rtkit.component.contexts.context import ExecutionContext
from rtkit.errors import NotFound
from rtkit.openrtm.api.identity import type_of
from rtkit.openrtm.api.parameters import BoundConfiguration
from rtkit.openrtm.corba.enumerations import OK
from rtkit.rtc.profiles import TypeProfile

CALLBACKS = {
    "on_initialize": "onInitialize",
    "on_finalize": "onFinalize",
    "on_startup": "onStartup",
    "on_shutdown": "onShutdown",
    "on_activated": "onActivated",
    "on_deactivated": "onDeactivated",
    "on_aborting": "onAborting",
    "on_error": "onError",
    "on_reset": "onReset",
    "on_execute": "onExecute",
    "on_state_update": "onStateUpdate",
    "on_rate_changed": "onRateChanged",
}
_OTHERS = 1000
"""Number of the first execution context that another component owns."""
_all: WeakSet[HeldComponent] = WeakSet()
being_made: ContextVar[HeldComponent | None] = ContextVar("being_made", default=None)
"""The component whose object is being constructed."""


class HeldComponent(Component):
    """A component that holds the object of an author's class.

    Attributes:
        servant_class: The author's class.
        described: What its module says of it, by dotted name.
        servant: The author's object.
    """

    is_made_late: ClassVar[bool] = True
    configuration_class: ClassVar[type[Configuration]] = BoundConfiguration
    servant_class: ClassVar[Any]
    described: ClassVar[Mapping[str, str]] = {}
    manager: ClassVar[Any] = None

    def __init__(self, instance: str, options: Mapping[str, str] | None = None) -> None:
        super().__init__(instance, options)
        self._context_numbers: dict[str, int] = {}
        _all.add(self)
        token = being_made.set(self)
        try:
            self.servant: Any = self.servant_class(self.manager)
        finally:
            being_made.reset(token)
        for name, theirs in CALLBACKS.items():
            function = getattr(self.servant, theirs)
            if not getattr(function, "is_default", False):
                setattr(self, name, _Callback(function, self.context_number))

    @classmethod
    def type_profile(cls) -> TypeProfile:
        """Return the identity that its module gives it."""
        return type_of(cls.described, cls.__name__)

    @property
    def variables(self) -> BoundConfiguration:
        """Its configuration, which is bound to variables."""
        assert isinstance(self.configuration, BoundConfiguration)
        return self.configuration

    @property
    def parameters_declared(self) -> Mapping[str, Parameter[Any]]:
        """Its parameters as its module describes and binds them."""
        return self.variables.declared()

    def add_port(self, port: Any) -> None:
        """Add a port, also while it is alive.

        Raises:
            Refused: One of that name exists.
        """
        self._add(port)
        self.show_changes()

    def remove_port(self, port: Any) -> bool:
        """Remove a port without connectors; return whether it had been added."""
        if port.connectors or self.ports.get(port.name) is not port:
            return False
        self.ports = {name: each for name, each in self.ports.items() if each is not port}
        self.show_changes()
        return True

    def show_changes(self) -> None:
        """Have everybody see its ports as they are now."""
        for context in self.participations:
            context.submit(context.notify)

    def context_number(self, handle: str) -> int:
        """Return the number of a context: from 0 of its own ones, from 1000 of others."""
        known = self._context_numbers.get(handle)
        if known is None:
            is_own = handle in self.contexts
            known = [*self.contexts].index(handle) if is_own else self._next_number()
            self._context_numbers[handle] = known
        return known

    def _next_number(self) -> int:
        return max((each + 1 for each in self._context_numbers.values()), default=0) | _OTHERS

    def context_of(self, number: int) -> ExecutionContext:
        """Return the context of a number.

        Raises:
            NotFound: It takes part in none of that number.
        """
        for each in (*self.contexts.values(), *self.participations):
            if self.context_number(each.handle_for(self)) == number:
                return each
        raise NotFound(f"{self.instance} takes part in no execution context {number}")

    def _configure(self) -> None:
        self.options = {**self.described, **self.options}
        given: dict[str, dict[str, str]] = {}
        for key, text in self.described.items():
            set_id, _, name = key.removeprefix("conf.").partition(".")
            if key.startswith("conf.") and name:
                given.setdefault(set_id, {})[name] = text
        for set_id, texts in given.items():
            self.configuration.declare(set_id, texts)
        self._declare_options()
        active = self.options.get(ACTIVE_SET, "")
        self.configuration.activate(active if active in self.configuration.sets else DEFAULT)
        self.configuration.update()


class _Callback:
    # A callback of the object, called with the number of the context in place of its id. It has
    # the code of the author's function, so that a failure is shown where that stands, and its text.

    __slots__ = ("__code__", "__doc__", "_call", "_number_of")

    def __init__(self, call: Callable[..., Any], number_of: Callable[[str], int]) -> None:
        self.__code__ = getattr(call, "__code__", None)
        self.__doc__ = call.__doc__
        self._call = call
        self._number_of = number_of

    def __call__(self, *contexts: str) -> Any:
        code = self._call(*map(self._number_of, contexts))
        return None if code is OK else code


def living() -> list[HeldComponent]:
    """Return the components of this process that hold objects, and are alive."""
    return sorted((each for each in _all if each.is_alive), key=lambda each: each.instance)


def held_class(
    servant_class: Any, described: Mapping[str, str], manager: Any
) -> type[HeldComponent]:
    """Return the component class that holds objects of an author's class."""
    body = {
        "__module__": __name__,
        "__doc__": described.get("description") or servant_class.__doc__,
        "servant_class": servant_class,
        "described": described,
        "manager": manager,
    }
    return type(servant_class.__name__, (servant_class.holder_class,), body)
