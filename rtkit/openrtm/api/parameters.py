"""Parameters that are bound to lists of one element, which change between callbacks."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from copy import deepcopy
from typing import Any, NamedTuple

from rtkit.component.configuration.config import DEFAULT, Configuration
from rtkit.component.configuration.kinds import ParameterKind
from rtkit.component.configuration.parameter import Parameter
from rtkit.errors import Malformed, RtkitError
from rtkit.openrtm.api.component_listeners import ListenedConfiguration
from rtkit.openrtm.api.properties import Properties
from rtkit.openrtm.api.string_util import Convert, stringTo

_KINDS = {bool: "int", int: "int", float: "double", str: "string"}


class Binding(NamedTuple):
    """A parameter and the variable that it is bound to: a list whose first element it sets."""

    variable: list[Any]
    convert: Convert
    default: str

    def assign(self, text: str) -> None:
        """Set the variable to what a text stands for, else to what the default stands for."""
        done, value = self.convert(self.variable[0], text)
        if not done:
            _, value = self.convert(value, self.default)
        self.variable[0] = value


class BoundConfiguration(Configuration):
    """Configuration sets whose values go into variables of the component.

    Attributes:
        listeners: Called with set and parameter after each that was assigned.
    """

    def __init__(self, report: Callable[[str], None]) -> None:
        super().__init__(report)
        self._bindings: dict[str, Binding] = {}
        self._described: set[tuple[str, str, str]] = set()
        self.listeners: list[Callable[[str, str], object]] = []

    def declare(self, set_id: str, values: Mapping[str, str]) -> None:
        """Give initial text to a set."""
        super().declare(set_id, values)
        self._described |= {(set_id, name, text) for name, text in values.items()}

    def misfits(self, set_id: str, values: Mapping[str, str]) -> str:
        """Return the texts that the parameters cannot have; OpenRTM takes all that files give."""
        others = {n: text for n, text in values.items() if (set_id, n, text) not in self._described}
        return super().misfits(set_id, others)

    def bind_variable(self, name: str, variable: list[Any], default: str, convert: Convert) -> bool:
        """Bind a parameter; its variable has the value of the active set from now on.

        Return False where OpenRTM would: without name or default, bound before, or with a default
        that cannot be converted.
        """
        if not name or not default or name in self._bindings:
            return False
        done, variable[0] = convert(variable[0], default)
        if not done:
            return False
        binding = self._bindings[name] = Binding(variable, convert, default)
        self.bind(name, default, _kind(variable[0], convert))
        text = self.sets[self.active_set].get(name, default)
        binding.assign(text)
        self.values[name] = text
        return True

    def unbind_variable(self, name: str) -> bool:
        """Leave a variable as it is from now on; return whether there was one."""
        return self._bindings.pop(name, None) is not None

    def is_bound(self, name: str) -> bool:
        """Return whether a variable is bound to a parameter."""
        return name in self._bindings

    def declared(self) -> dict[str, Parameter[Any]]:
        """Return its parameters with their hints, and what further sets have for them."""
        sets = self.sets
        hints = {name: sets.get(f"__{name}__", {}) for name in ("constraints", "widget")}
        others = [each for each in sets if each != DEFAULT and not each.startswith("__")]
        found: dict[str, Parameter[Any]] = {}
        for name, text in sets[DEFAULT].items():
            made = found[name] = Parameter(
                self._plain(name, text),
                constraint=hints["constraints"].get(name, ""),
                widget=hints["widget"].get(name, ""),
                name=name,
            )
            made.sets = {each: sets[each][name] for each in others if name in sets[each]}
        return found

    def _plain(self, name: str, text: str) -> Any:
        """Return what a text of a parameter stands for; the text where that has no kind here."""
        binding = self._bindings.get(name)
        if binding is None or binding.convert is not stringTo:
            return text
        value = binding.convert(deepcopy(binding.variable[0]), text)[1]
        is_numbers = isinstance(value, list) and {*map(type, value)} <= {int, float}
        return tuple(value) if is_numbers else text if isinstance(value, list) else value

    def apply(self, set_id: str, texts: Mapping[str, str]) -> None:
        """Assign the texts of a set to the variables."""
        before = self.values
        super().apply(set_id, texts)
        for name, binding in self._bindings.items():
            if name in texts and before.get(name) != texts[name]:
                binding.assign(texts[name])
                for listener in self.listeners:
                    listener(set_id, name)


def _kind(value: Any, convert: Convert) -> ParameterKind:
    """Return the kind of a parameter whose value is kept as text, once it can be converted."""

    def read(text: str) -> str:
        done = not text or convert(deepcopy(value), text)[0]
        if not done:
            raise Malformed(f"{text!r} cannot be converted to {type(value).__name__}")
        return text

    if isinstance(value, list):
        inner = _KINDS.get(type(value[0]), "string") if value else "double"
        return ParameterKind(f"vector<{inner}>", read, str)
    return ParameterKind(_KINDS.get(type(value), "string"), read, str)


class ConfigAdmin(ListenedConfiguration):
    """The configuration of a component under the names of OpenRTM."""

    _configuration: BoundConfiguration

    def __init__(self, configuration: BoundConfiguration) -> None:
        self._configuration = configuration

    def bindParameter(
        self, param_name: str, var: list[Any], def_val: str, trans: Convert | None = None
    ) -> bool:
        """Bind a parameter to the only element of a list."""
        return self._configuration.bind_variable(param_name, var, def_val, trans or stringTo)

    def unbindParameter(self, param_name: str) -> bool:
        """Leave a variable as it is from now on."""
        return self._configuration.unbind_variable(param_name)

    def isExist(self, param_name: str) -> bool:
        """Return whether a variable is bound to a parameter."""
        return self._configuration.is_bound(param_name)

    def update(self, config_set: str | None = None, config_param: str | None = None) -> None:
        """Assign a set, or one parameter of it, else the active one if it was changed."""
        configuration = self._configuration
        if config_set is None:
            configuration.update()
            return
        texts = configuration.sets.get(config_set, {})
        if config_param is not None:
            texts = {name: text for name, text in texts.items() if name == config_param}
        configuration.apply(configuration.active_set, texts)

    def isChanged(self) -> bool:
        """Return whether another set waits for the next update."""
        return self._configuration.is_pending

    def isActive(self) -> bool:
        """Return whether a set is active, as one always is."""
        return True

    def getActiveId(self) -> str:
        """Return the name of the active set."""
        return self._configuration.active_set

    def haveConfig(self, config_id: str) -> bool:
        """Return whether there is a set of that name."""
        return config_id in self._configuration.sets

    def getConfigurationSets(self) -> list[Properties]:
        """Return all sets."""
        return [self.getConfigurationSet(each) for each in self._configuration.sets]

    def getConfigurationSet(self, config_id: str) -> Properties:
        """Return the texts of a set; empty where there is none of that name."""
        made = Properties(config_id)
        for name, text in self._configuration.sets.get(config_id, {}).items():
            made.setProperty(name, text)
        return made

    def getActiveConfigurationSet(self) -> Properties:
        """Return the texts of the active set."""
        return self.getConfigurationSet(self.getActiveId())

    def setConfigurationSetValues(self, config_set: Properties) -> bool:
        """Change texts of a set; return whether they fit."""
        return self._changes(
            lambda: self._configuration.set(config_set.getName(), config_set.texts())
        )

    def addConfigurationSet(self, configset: Properties) -> bool:
        """Add a set; return whether that is possible."""
        return self._changes(
            lambda: self._configuration.add_set(configset.getName(), configset.texts())
        )

    def removeConfigurationSet(self, config_id: str) -> bool:
        """Remove a set that was added at run time; return whether it was one."""
        return self._changes(lambda: self._configuration.remove_set(config_id))

    def activateConfigurationSet(self, config_id: str) -> bool:
        """Have a set take effect at the next update; return whether it may."""
        return self._changes(lambda: self._configuration.activate(config_id))

    def _changes(self, change: Callable[[], None]) -> bool:
        try:
            change()
        except RtkitError as error:
            self._configuration.report(str(error))
            return False
        return True
