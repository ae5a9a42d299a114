"""Dataclasses that cost little to define: for types that come with each start of a command.

The standard `dataclass` compiles half a dozen methods for each class when it is defined. That takes
0.5 ms a class, more than most classes are worth in a command of 60 ms. This one has the same
meaning for the options that it takes, and makes attributes of the standard one on demand
(`dataclasses.fields`, `is_dataclass`, `inspect.signature`). Type checkers take it for the standard
one.

See decision 31.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Mapping
from functools import cache, partial
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, TypeVar, dataclass_transform

__all__ = [
    "MISSING", "Record", "dataclass", "field", "fields", "is_record", "make_dataclass", "replace",
]  # fmt: skip

T = TypeVar("T")
_COMPILED_AFTER = 50
"""How many records of a class a loop sets the fields of; it takes 2 µs longer for each."""


class _Missing:
    """Marks a field without default, or without one that a factory makes for each object."""

    def __repr__(self) -> str:
        return "<factory>"  # where a signature shows it


_MISSING = _Missing()


class _Field(NamedTuple):
    """One field of a class; names are those of the standard library."""

    default: Any = _MISSING
    default_factory: Any = _MISSING
    repr: bool = True
    compare: bool = True
    name: str = ""
    type: Any = None

    @property
    def is_required(self) -> bool:
        return self.default is _MISSING and self.default_factory is _MISSING


def is_record(cls: object) -> bool:
    """Return whether a class was made by `dataclass` of this module."""
    return hasattr(cls, "__record_fields__")


def _field(
    *,
    default: Any = _MISSING,
    default_factory: Any = _MISSING,
    repr: bool = True,
    compare: bool = True,
) -> Any:
    return _Field(default, default_factory, repr, compare)


def _fields(record: Any) -> tuple[_Field, ...]:
    return tuple(record.__record_fields__.values())


def _replace(record: Any, **changes: Any) -> Any:
    cls = type(record)
    if not is_record(cls):
        import dataclasses

        return dataclasses.replace(record, **changes)
    for name in cls.__record_fields__:
        if name not in changes:
            changes[name] = getattr(record, name)
    return cls(**changes)


def _dataclass(
    *, slots: bool, frozen: bool = False, order: bool = False, eq: bool = True
) -> Callable[[type], type]:
    if not slots:
        raise TypeError("without slots there is the standard dataclass")

    def decorate(cls: type) -> type:
        namespace = {**vars(cls), "__qualname__": cls.__qualname__}
        return _made(type(cls), cls.__bases__, namespace, frozen=frozen, order=order, eq=eq)

    return decorate


def _made(
    make: Callable[[str, tuple[type, ...], dict[str, Any]], type],
    bases: tuple[type, ...],
    namespace: dict[str, Any],
    *,
    frozen: bool = True,
    order: bool = False,
    eq: bool = True,
) -> type:
    columns: dict[str, _Field] = {}
    for base in reversed([each for parent in bases for each in parent.__mro__]):
        columns |= vars(base).get("__record_fields__", {})
    inherited, title = set(columns), namespace["__qualname__"].rpartition(".")[2]
    for name, hint in namespace.get("__annotations__", {}).items():
        default = namespace.pop(name, _MISSING)
        if isinstance(default, _Field):
            columns[name] = default._replace(name=name, type=hint)
        else:
            columns[name] = _Field(default, name=name, type=hint)
    _check_order(title, columns)
    for name in ("__dict__", "__weakref__"):
        namespace.pop(name, None)
    namespace["__slots__"] = tuple(name for name in columns if name not in inherited)
    namespace["__record_fields__"] = columns
    namespace["__match_args__"] = tuple(columns)
    namespace["__repr__"] = namespace.get("__repr__", _repr)
    if eq:
        namespace.update(_comparing(columns, frozen, order) | _own(namespace))
    # Before the class is made: to set an attribute of a class takes as long as to make a field.
    namespace.update(
        __init__=_initialiser(lambda: made, columns),
        __dataclass_params__=_params(frozen, order, eq),
        __dataclass_fields__=_OnDemand(lambda: _standard(columns)),
        __signature__=_OnDemand(lambda: _signature(made, columns)),
        **(_freezing(lambda: made, columns) if frozen else {}),
    )
    made = make(title, bases, namespace)
    return made


@cache
def _params(frozen: bool, order: bool, eq: bool) -> SimpleNamespace:
    return SimpleNamespace(init=True, repr=True, eq=eq, order=order, frozen=frozen)


def make_dataclass(
    name: str, columns: Iterable[tuple[str, Any, Any]], *, module: str = __name__, doc: str = ""
) -> type:
    """Return a frozen data class; `columns` are name, annotation and default, or MISSING."""
    given = list(columns)
    bare = {
        **{each: default for each, _, default in given if default is not _MISSING},
        "__annotations__": {each: hint for each, hint, _ in given},
        "__doc__": doc,
        "__module__": module,
        "__qualname__": name,
    }
    return _made(lambda _, bases, namespace: type(name, bases, namespace), (object,), bare)


def _own(namespace: Mapping[str, Any]) -> dict[str, Any]:
    """Return the comparison methods that a class defines itself."""
    return {name: namespace[name] for name in ("__eq__", "__hash__") if namespace.get(name)}


def _check_order(title: str, columns: Mapping[str, _Field]) -> None:
    has_default = False
    for name, column in columns.items():
        if column.is_required and has_default:
            raise TypeError(f"{title}: {name} without a default behind one that has one")
        has_default = has_default or not column.is_required


# making


def _initialiser(owner: Callable[[], Any], columns: Mapping[str, _Field]) -> Callable[..., None]:
    """Return a constructor that sets fields in a loop, and has one compiled when it is worth it.

    `owner` returns its class, which is not there yet.
    """
    rows: list[tuple[str, Callable[[Any, Any], None], Any, Any]] = []
    is_checked = False
    made = 0

    def __init__(self: Any, *args: Any, **named: Any) -> None:  # noqa: N807
        nonlocal made, rows, is_checked
        made += 1
        if not rows:
            cls = owner()
            is_checked = hasattr(cls, "__post_init__")  # first: another thread may look at rows
            rows = [(name, getattr(cls, name).__set__, *c[:2]) for name, c in columns.items()]
        left = len(named)
        is_good = made <= _COMPILED_AFTER and len(args) <= len(rows)
        for (_, put, _, _), value in zip(rows, args, strict=False):
            put(self, value)
            is_good = is_good and value is not _MISSING
        for name, put, default, factory in rows[len(args) :] if is_good else ():
            if name in named:
                put(self, named[name])
                left -= 1
                is_good = is_good and named[name] is not _MISSING  # as a signature shows it
            elif default is not _MISSING:
                put(self, default)
            elif factory is not _MISSING:
                put(self, factory())
            else:
                is_good = False
        if not is_good or left:
            cls = owner()
            cls.__init__ = _compiled(cls, columns)
            cls.__init__(self, *args, **named)  # which also raises what is wrong
        elif is_checked:
            self.__post_init__()

    return __init__


def _compiled(cls: Any, columns: Mapping[str, _Field]) -> Callable[..., None]:
    scope: dict[str, Any] = {"MISSING": _MISSING}
    parameters, lines = ["self"], []
    for number, (name, column) in enumerate(columns.items()):
        scope[f"_put{number}"] = getattr(cls, name).__set__
        parameter, value = name, name
        if column.default is not _MISSING:
            parameter = f"{name}=_default{number}"
            scope[f"_default{number}"] = column.default
        elif column.default_factory is not _MISSING:
            parameter = f"{name}=MISSING"
            value = f"_factory{number}() if {name} is MISSING else {name}"
            scope[f"_factory{number}"] = column.default_factory
        parameters.append(parameter)
        lines.append(f" _put{number}(self, {value})")
    if hasattr(cls, "__post_init__"):
        lines.append(" self.__post_init__()")
    text = f"def __init__({', '.join(parameters)}):\n" + "\n".join(lines or [" pass"])
    exec(text, scope)
    made: Callable[..., None] = scope["__init__"]
    made.__qualname__ = f"{cls.__qualname__}.__init__"
    made.__module__ = cls.__module__
    made.__annotations__ = {name: column.type for name, column in columns.items()}
    made.__annotations__["return"] = None
    return made


# comparing and showing


def _repr(self: Any) -> str:
    shown = (c.name for c in self.__record_fields__.values() if c.repr)
    values = ", ".join(f"{name}={getattr(self, name)!r}" for name in shown)
    return f"{type(self).__qualname__}({values})"


def _comparing(columns: Mapping[str, _Field], frozen: bool, order: bool) -> dict[str, Any]:
    names = [name for name, column in columns.items() if column.compare]
    key: Callable[[Any], Any] = operator.attrgetter(*names) if names else lambda _: ()

    def comparing(compare: Callable[[Any, Any], bool]) -> Callable[[Any, Any], Any]:
        def method(self: Any, other: Any) -> Any:
            return compare(key(self), key(other)) if type(other) is type(self) else NotImplemented

        return method

    methods: dict[str, Any] = {"__eq__": comparing(operator.eq), "__hash__": None}
    if frozen:
        methods["__hash__"] = lambda self: hash(key(self))
    if order:
        methods |= {f"__{each}__": comparing(getattr(operator, each)) for each in _ORDER}
    return methods


_ORDER = ("lt", "le", "gt", "ge")


def _freezing(owner: Callable[[], Any], columns: Mapping[str, _Field]) -> dict[str, Any]:
    """Return the methods of a class, which `owner` returns, whose objects do not change."""

    def refuse(self: Any, name: str, what: str) -> None:
        if type(self) is owner() or name in columns:
            from dataclasses import FrozenInstanceError

            raise FrozenInstanceError(f"cannot {what} field {name!r}")

    def set_attribute(self: Any, name: str, value: Any) -> None:
        refuse(self, name, "assign to")
        super(owner(), self).__setattr__(name, value)

    def delete_attribute(self: Any, name: str) -> None:
        refuse(self, name, "delete")
        super(owner(), self).__delattr__(name)

    def get_state(self: Any) -> list[Any]:
        return [getattr(self, name) for name in columns]

    def set_state(self: Any, state: list[Any]) -> None:
        for name, value in zip(columns, state, strict=True):
            getattr(owner(), name).__set__(self, value)

    return {
        "__setattr__": set_attribute,
        "__delattr__": delete_attribute,
        "__getstate__": get_state,
        "__setstate__": set_state,
    }


# what the standard library finds


class _OnDemand:
    """An attribute of a class that is made when somebody asks for it."""

    def __init__(self, make: Callable[[], Any]) -> None:
        self._make = make
        self._made: Any = None

    def __get__(self, _instance: object, _owner: type) -> Any:
        if self._made is None:
            self._made = self._make()
        return self._made


def _standard(columns: Mapping[str, _Field]) -> dict[str, Any]:
    import dataclasses

    made = {}
    for name, column in columns.items():
        given = {
            key: value
            for key, value in column._asdict().items()
            if key not in ("name", "type") and value is not _MISSING
        }
        field: Any = dataclasses.field(**given)
        field.name, field.type, field.kw_only = name, column.type, False
        kind: Any = dataclasses
        field._field_type = kind._FIELD  # noqa: SLF001 - how `dataclasses.fields` knows them
        made[name] = field
    return made


def _signature(cls: Any, columns: Mapping[str, _Field]) -> Any:
    import inspect

    whole = inspect.signature(_compiled(cls, columns))
    return whole.replace(parameters=list(whole.parameters.values())[1:])


if TYPE_CHECKING:
    from dataclasses import MISSING, dataclass, field, fields, replace
else:
    MISSING, dataclass, field, fields, replace = _MISSING, _dataclass, _field, _fields, _replace


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
class _RecordType(type):
    def __new__(cls, _name: str, bases: tuple[type, ...], namespace: dict[str, Any]) -> Any:
        return _made(partial(type.__new__, cls), bases, namespace)


class Record(metaclass=_RecordType):
    """Base of records: a class derived from it is a frozen dataclass with slots, as it stands."""

    if TYPE_CHECKING:
        __dataclass_fields__: ClassVar[dict[str, Any]]
