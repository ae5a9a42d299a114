"""Services as components: a component type made of any class, configured as its constructor is.

An instance serves an object of the class while it is active. What the object reports as its
``status`` is seen in the state of the component.
"""

from __future__ import annotations

import inspect
import re
import sys
import types
import typing
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, NamedTuple

import rtkit.component as rtc
from rtkit.component.configuration.parameter import Parameter
from rtkit.errors import Malformed, Refused
from rtkit.property.annotations import bare, hints_of_function, spec_of
from rtkit.property.conversion import to_value
from rtkit.property.fitting import from_value
from rtkit.property.property_spec import PropertySpec
from rtkit.property.reading import read
from rtkit.property.writing import write

_EMPTY: dict[Any, bool | int | float] = {bool: False, int: 0, float: 0.0}
_RATE_HZ = 5.0
_OPENED = "What else is opened, and for which other hosts: port=0 http=8080 hosts=robot1"
_SEVERAL = ("settable", "hide", "notify", "hosts")
"""Keywords of `rtkit.serve` that take several values."""


class _Argument(NamedTuple):
    """Argument of a constructor, and how its parameter is read."""

    hint: Any
    default: Any
    is_text: bool


class ServiceComponent(rtc.Component):
    """Component that serves an object of a class while it is active."""

    rate = _RATE_HZ
    served_class: ClassVar[Callable[..., Any]]
    arguments: ClassVar[Mapping[str, _Argument]] = {}

    def on_activated(self, context: str) -> None:
        """Make the object of its parameters, and serve it."""
        from rtkit.wires.serve import serve

        self.on_deactivated()
        values = self.configuration.values
        given = {name: _read(name, values[name], each) for name, each in self.arguments.items()}
        self._thing = type(self).served_class(**given)
        name = str(values["service"]) or self.instance.replace(".", "/")
        self._served = serve(self._thing, name, **_endpoints(str(values["endpoints"])))

    def on_execute(self, context: str) -> None:
        """Go into Error while the object reports that it has failed; it is still served then."""
        getter = getattr(self._thing, "get_status", None)
        status = getter() if callable(getter) else getattr(self._thing, "status", "")
        if isinstance(status, str) and status.partition(":")[0] == "failed":
            raise Refused(status)

    def on_deactivated(self, context: str = "") -> None:
        """Serve it no longer; the next activation makes a new object."""
        served = vars(self).pop("_served", None)
        if served is not None:
            served.close()

    on_reset = on_finalize = on_deactivated


def component_of(
    served_class: type, *, version: str = "", category: str = "service"
) -> type[ServiceComponent]:
    """Return the type of the components that serve objects of a class.

    Its parameters are the arguments of the constructor, with their defaults, ranges, units and
    choices, and ``service``: the name, by default that of the instance with slashes for dots; and
    ``endpoints``: what else `rtkit.serve` opens, ``port=0 http=8080 hosts=robot1``. Values that
    parameters do not have, lists of texts for example, are written as those of properties. They
    count from the next activation on.

    Args:
        served_class: Any class.
        version: Of the type; by default the class's own ``version``.
        category: Of the type.

    Raises:
        Malformed: An argument has no name.
    """
    init = vars(served_class).get("__init__") or served_class.__init__  # type: ignore[misc]
    hints = hints_of_function(init)
    members: dict[str, Any] = {}
    arguments: dict[str, _Argument] = {}
    for each in inspect.signature(served_class).parameters.values():
        if each.kind in (each.VAR_KEYWORD, each.VAR_POSITIONAL):
            continue
        if each.kind is each.POSITIONAL_ONLY:
            raise Malformed(f"{served_class.__name__}: argument {each.name} has no name")
        doc = _documented(served_class, each.name)
        parameter, argument = _parameter(each, hints.get(each.name), doc)
        members[f"argument_{each.name}"], arguments[each.name] = parameter, argument
    members["service_name"] = Parameter("", name="service", doc="Name of the service")
    members["endpoints"] = Parameter("", doc=_OPENED)
    own = {
        "__doc__": served_class.__doc__,
        "__module__": served_class.__module__,
        "served_class": served_class,
        "arguments": arguments,
        "vendor": (sys.modules[served_class.__module__].__package__ or "").partition(".")[0],
        "category": category,
        "version": version or str(getattr(served_class, "version", "") or "1.0"),
    }
    return type(served_class.__name__, (ServiceComponent,), own | members)


def init_of(
    served_class: type, *, version: str = "", category: str = "service"
) -> Callable[[rtc.Manager], None]:
    """Return the init function of a module: it registers `component_of` a class."""

    def init(manager: rtc.Manager) -> None:
        manager.register_factory(component_of(served_class, version=version, category=category))

    return init


def _parameter(given: inspect.Parameter, hint: Any, doc: str) -> tuple[Parameter[Any], _Argument]:
    plain = bare(hint)
    is_required = given.default is inspect.Parameter.empty
    default = _EMPTY.get(plain, "") if is_required else given.default
    if plain is float and type(default) is int:
        default = float(default)
    spec = spec_of(hint, default, "rw", doc)
    is_vector = isinstance(default, tuple) and bool(default) and spec.type.base == "vector"
    is_plain = type(default) in (bool, int, float) or is_vector
    is_union = typing.get_origin(plain) in (typing.Union, types.UnionType)
    is_string = isinstance(default, str) or plain is str or (is_union and str in plain.__args__)
    is_text = not (is_plain or is_string)
    value = default
    if not is_plain:
        is_as_it_is = default is None or isinstance(default, str)
        value = (default or "") if is_as_it_is else write(to_value(default))  # type: ignore[arg-type]
    constraint = _constraint(spec) if spec.choices or not (is_text or is_vector) else ""
    doc = re.sub(rf"\s*\[{re.escape(spec.unit)}\]\.?$", "", doc) if spec.unit else doc
    made = Parameter(value, unit=spec.unit, doc=doc, constraint=constraint, name=given.name)
    return made, _Argument(hint, inspect.Parameter.empty if is_required else default, is_text)


def _constraint(spec: PropertySpec) -> str:
    if spec.choices:
        return f"({','.join(map(str, spec.choices))})"
    low = "" if spec.minimum is None else f"{spec.minimum:g}<="
    high = "" if spec.maximum is None else f"<={spec.maximum:g}"
    return f"{low}x{high}" if low or high else ""


def _read(name: str, value: Any, argument: _Argument) -> Any:
    """Return the argument of a constructor that the value of a parameter stands for."""
    if value == "" and argument.default is inspect.Parameter.empty:
        raise Malformed(f"parameter {name} is to be set")
    if value == "":
        return argument.default
    return from_value(read(value), argument.hint, argument.default) if argument.is_text else value


def _documented(served_class: type, name: str) -> str:
    """Return what the documentation of a class says of an argument."""
    docs = (served_class.__doc__, served_class.__init__.__doc__)  # type: ignore[misc]
    rule = re.compile(rf"^(\s+){name}(?: \(.*\))?: (.+(?:\n\1\s+\S.*)*)$", re.MULTILINE)
    found = next((each for each in (rule.search(doc or "") for doc in docs) if each), None)
    return "" if found is None else " ".join(found[2].replace("``", "").split())


def _endpoints(text: str) -> dict[str, Any]:
    """Read ``port=0 http=8080 notify=log/*``."""
    given: dict[str, Any] = {}
    for each in text.split():
        key, mark, value = each.partition("=")
        if not mark:
            raise Malformed(f"not KEY=VALUE: {each} (endpoints)")
        if key in _SEVERAL:
            given.setdefault(key, []).append(value)
        else:
            given[key] = value
    return given
