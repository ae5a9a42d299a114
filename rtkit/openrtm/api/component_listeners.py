"""Listeners to the configuration and to the callbacks of a component, as OpenRTM numbers them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

from rtkit.component.contexts.callbacks import describe_failure
from rtkit.openrtm.api.connector_listeners import name_of
from rtkit.openrtm.corba.enumerations import ITEMS, OK

Listener = Callable[..., Any]


class ConfigurationParamListenerType:
    """Events of a parameter."""

    ON_UPDATE_CONFIG_PARAM, CONFIG_PARAM_LISTENER_NUM = range(2)


class ConfigurationSetListenerType:
    """Events of the values of a set."""

    ON_SET_CONFIG_SET, ON_ADD_CONFIG_SET, CONFIG_SET_LISTENER_NUM = range(3)


class ConfigurationSetNameListenerType:
    """Events of a set."""

    (
        ON_UPDATE_CONFIG_SET, ON_REMOVE_CONFIG_SET, ON_ACTIVATE_CONFIG_SET,
        CONFIG_SET_NAME_LISTENER_NUM,
    ) = range(4)  # fmt: skip


class PreComponentActionListenerType:
    """Callbacks, before each."""

    (
        PRE_ON_INITIALIZE, PRE_ON_FINALIZE, PRE_ON_STARTUP, PRE_ON_SHUTDOWN, PRE_ON_ACTIVATED,
        PRE_ON_DEACTIVATED, PRE_ON_ABORTING, PRE_ON_ERROR, PRE_ON_RESET, PRE_ON_EXECUTE,
        PRE_ON_STATE_UPDATE, PRE_ON_RATE_CHANGED, PRE_COMPONENT_ACTION_LISTENER_NUM,
    ) = range(13)  # fmt: skip


class PostComponentActionListenerType:
    """Callbacks, after each."""

    (
        POST_ON_INITIALIZE, POST_ON_FINALIZE, POST_ON_STARTUP, POST_ON_SHUTDOWN, POST_ON_ACTIVATED,
        POST_ON_DEACTIVATED, POST_ON_ABORTING, POST_ON_ERROR, POST_ON_RESET, POST_ON_EXECUTE,
        POST_ON_STATE_UPDATE, POST_ON_RATE_CHANGED, POST_COMPONENT_ACTION_LISTENER_NUM,
    ) = range(13)  # fmt: skip


class ConfigurationParamListener:
    """Base of listeners to a parameter."""

    def __call__(self, config_set_name: str, config_param_name: str) -> Any:
        """React."""

    @staticmethod
    def toString(status: int) -> str:
        """Return the name of an event."""
        return name_of(ConfigurationParamListenerType, status)


class ConfigurationSetListener:
    """Base of listeners to the values of a set."""

    def __call__(self, config_set: Any) -> Any:
        """React; `config_set` has the values."""

    @staticmethod
    def toString(status: int) -> str:
        """Return the name of an event."""
        return name_of(ConfigurationSetListenerType, status)


class ConfigurationSetNameListener:
    """Base of listeners to a set."""

    def __call__(self, config_set_name: str) -> Any:
        """React."""

    @staticmethod
    def toString(status: int) -> str:
        """Return the name of an event."""
        return name_of(ConfigurationSetNameListenerType, status)


class PreComponentActionListener:
    """Base of listeners before callbacks."""

    def __call__(self, ec_id: int) -> Any:
        """React."""

    @staticmethod
    def toString(status: int) -> str:
        """Return the name of an event."""
        return name_of(PreComponentActionListenerType, status)


class PostComponentActionListener:
    """Base of listeners after callbacks."""

    def __call__(self, ec_id: int, ret: Any) -> Any:
        """React; `ret` is the outcome."""

    @staticmethod
    def toString(status: int) -> str:
        """Return the name of an event."""
        return name_of(PostComponentActionListenerType, status)


_OF_PARAMETERS = ("parameter_assigned",)
_OF_SETS = ("set_updated", "set_added")
_OF_SET_NAMES = ("set_taken_over", "set_removed", "set_activated")


class ListenedConfiguration(ABC):
    """Base of configurations that can be listened to.

    A listener runs on the thread that causes the change: a set that becomes the active one, and
    its parameters, change on the thread that drives the component.
    """

    _configuration: Any

    def addConfigurationParamListener(self, type: int, listener: Listener) -> None:
        """Have a listener called with set and name of each parameter that was changed."""
        self._changes_of(_OF_PARAMETERS[type]).append(listener)

    def removeConfigurationParamListener(self, type: int, listener: Listener) -> None:
        """Call a listener no more."""
        _remove(self._changes_of(_OF_PARAMETERS[type]), listener)

    def addConfigurationSetListener(self, type: int, listener: Listener) -> None:
        """Have a listener called with each set that was changed, or added."""
        self._changes_of(_OF_SETS[type]).append(listener)

    def removeConfigurationSetListener(self, type: int, listener: Listener) -> None:
        """Call a listener no more."""
        _remove(self._changes_of(_OF_SETS[type]), listener)

    def addConfigurationSetNameListener(self, type: int, listener: Listener) -> None:
        """Have a listener called with the name of each set that is taken over, or removed."""
        self._changes_of(_OF_SET_NAMES[type]).append(listener)

    def removeConfigurationSetNameListener(self, type: int, listener: Listener) -> None:
        """Call a listener no more."""
        _remove(self._changes_of(_OF_SET_NAMES[type]), listener)

    @abstractmethod
    def getConfigurationSet(self, config_id: str) -> Any:
        """Return the texts of a set."""

    def _changes_of(self, kind: str) -> list[Listener]:
        if "_listeners" not in vars(self):
            self._listeners: dict[str, list[Listener]] = {}
            self._configuration.changed = self._notify_of_set
            self._configuration.listeners.append(self._notify_of_parameter)
        return self._listeners.setdefault(kind, [])

    def _notify_of_parameter(self, set_id: str, name: str) -> None:
        self._notify("parameter_assigned", set_id, name)

    def _notify_of_set(self, change: str, name: str) -> None:
        if change in _OF_SETS:
            self._notify(change, self.getConfigurationSet(name))
        elif change in _OF_SET_NAMES:
            self._notify(change, name)
        if change == "set_activated":
            self._notify("set_taken_over", name)

    def _notify(self, kind: str, *arguments: Any) -> None:
        call_all(self._listeners.get(kind, ()), self._configuration.report, *arguments)


class ListenedComponent:
    """Base of components whose configuration and callbacks can be listened to."""

    rtkit_component: Any
    _configsets: Any

    def addConfigurationParamListener(self, type: int, memfunc: Listener, *_: Any) -> Listener:
        """Have a function called with set and name of each parameter that was changed."""
        self._configsets.addConfigurationParamListener(type, memfunc)
        return memfunc

    def removeConfigurationParamListener(self, type: int, listener: Listener) -> None:
        """Call a function no more."""
        self._configsets.removeConfigurationParamListener(type, listener)

    def addConfigurationSetListener(self, type: int, memfunc: Listener, *_: Any) -> Listener:
        """Have a function called with each set that was changed, or added."""
        self._configsets.addConfigurationSetListener(type, memfunc)
        return memfunc

    def removeConfigurationSetListener(self, type: int, listener: Listener) -> None:
        """Call a function no more."""
        self._configsets.removeConfigurationSetListener(type, listener)

    def addConfigurationSetNameListener(self, type: int, memfunc: Listener, *_: Any) -> Listener:
        """Have a function called with the name of each set that is taken over, or removed."""
        self._configsets.addConfigurationSetNameListener(type, memfunc)
        return memfunc

    def removeConfigurationSetNameListener(self, type: int, listener: Listener) -> None:
        """Call a function no more."""
        self._configsets.removeConfigurationSetNameListener(type, listener)

    def addPreComponentActionListener(self, type: int, memfunc: Listener, *_: Any) -> Listener:
        """Have a function called with the number of the context before each call of a callback."""
        self._action(type).before.append(memfunc)
        return memfunc

    def removePreComponentActionListener(self, type: int, listener: Listener) -> None:
        """Call a function no more."""
        _remove(self._action(type).before, listener)

    def addPostComponentActionListener(self, type: int, memfunc: Listener, *_: Any) -> Listener:
        """Have a function called with number and outcome after each call of a callback."""
        self._action(type).after.append(memfunc)
        return memfunc

    def removePostComponentActionListener(self, type: int, listener: Listener) -> None:
        """Call a function no more."""
        _remove(self._action(type).after, listener)

    def _action(self, number: int) -> NotifyingCallback:
        name = name_of(PreComponentActionListenerType, number).removeprefix("PRE_").lower()
        component = self.rtkit_component
        callback = getattr(component, name)
        if not isinstance(callback, NotifyingCallback):
            callback = NotifyingCallback(callback, component)
            setattr(component, name, callback)
        return callback


class NotifyingCallback:
    """A callback of a component, with functions that are called before and after.

    Attributes:
        before: Called with the number of the context.
        after: Called with that, and the outcome.
    """

    def __init__(self, callback: Callable[..., Any], component: Any) -> None:
        self.__code__ = getattr(getattr(callback, "__func__", callback), "__code__", None)
        self._callback = callback
        self._component = component
        self.before: list[Listener] = []
        self.after: list[Listener] = []

    def __call__(self, *contexts: str) -> Any:
        """Call them all."""
        component = self._component
        number = component.context_number(contexts[0]) if contexts else 0
        call_all(self.before, component.report, number)
        code, outcome = None, ITEMS["RTC_ERROR"]
        try:
            code = self._callback(*contexts)
            outcome = code or OK
        finally:
            call_all(self.after, component.report, number, outcome)
        return code


def call_all(
    listeners: list[Listener] | tuple[()], report: Callable[[str], object], *arguments: Any
) -> None:
    """Call listeners; what one raises is reported, and keeps nobody from anything."""
    for listener in tuple(listeners):
        try:
            listener(*arguments)
        except Exception as error:
            report(f"listener failed: {describe_failure(error, listener)}")


def _remove(listeners: list[Listener], listener: Listener) -> None:
    if listener in listeners:
        listeners.remove(listener)
