"""Resolves ``MODULE:FACTORY`` as typed to a component class."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import NamedTuple

from rtkit.component.base import Component
from rtkit.component.contexts.callbacks import describe_failure
from rtkit.component.factory import Factories
from rtkit.errors import Malformed, NotFound, Refused, RtkitError
from rtkit.modules.loader import import_source, registered_by
from rtkit.modules.neighbours import among_its_own
from rtkit.modules.search import SUFFIX, ModuleSource, Search
from rtkit.resources import resource


class FactoryOffer(NamedTuple):
    """A component class, and the init function of its module that offers it, if it is known."""

    cls: type[Component]
    file: str
    init: str


def component_class(typed: str, wanted: str) -> FactoryOffer:
    """Return the class that ``MODULE:FACTORY`` stands for.

    A factory is an init function, or a component class. Without one, the init function of the
    module is meant.

    Args:
        typed: As the user typed it.
        wanted: Name of the type, where a module offers several; else empty.

    Raises:
        NotFound: There is no such module, or no such name in it.
        Refused: The module cannot be used; says why and where.
        Malformed: It offers several types, or what is named is none.
    """
    path, name = _split(typed)
    source = module_source(typed)
    file = source.file
    with among_its_own(source):
        module = import_source(source)
    usual = f"{os.path.basename(file).removesuffix(SUFFIX)}Init"
    init = name or source.init or usual
    found = getattr(module, init, None)
    if isinstance(found, type) and issubclass(found, Component):
        return FactoryOffer(found, file, "")
    if found is not None and not callable(found):
        raise Malformed(f"{typed} is neither an init function nor a component class")
    with among_its_own(source):
        classes = registered_by(module, init, path, is_usual=init == usual)
    return FactoryOffer(_chosen(classes, typed, wanted), file, init)


def module_source(typed: str) -> ModuleSource:
    """Return the module of ``MODULE:FACTORY``, which is not imported.

    Raises:
        NotFound: There is no such module.
        Refused: It cannot be used; says why.
    """
    path, _ = _split(typed)
    folders = [".", *os.environ.get("RTKIT_MODULE_PATH", "").split(os.pathsep)]
    place = os.path.abspath(path) if "/" in path or os.path.isfile(path) else path
    search = Search([each for each in folders if each] + [resource("examples", "basic")])
    return search.read(place)


def _split(typed: str) -> tuple[str, str]:
    path, colon, name = typed.rpartition(":")
    return (path, name) if colon else (typed, "")


def _chosen(classes: Sequence[type[Component]], typed: str, wanted: str) -> type[Component]:
    for each in classes:
        Factories().register(each)  # refuses what no manager would take
    fitting = [each for each in classes if wanted in ("", each.type_profile().type_name)]
    if len(fitting) == 1:
        return fitting[0]
    names = ", ".join([each.type_profile().type_name for each in classes]) or "none"
    if not fitting:
        what = f"no type {wanted}; there are: {names}" if wanted else "no component type"
        raise NotFound(f"{typed} offers {what}")
    raise Malformed(f"{typed} offers several types; say --type: {names}")


def instance_of(cls: type[Component], typed: str, *, is_initialised: bool) -> Component:
    """Return an instance, on which nothing but on_initialize is called, if that is asked for.

    Raises:
        Refused: Its constructor or on_initialize failed; says why and where.
    """
    try:
        made = cls(f"{cls.type_profile().type_name}0")
        code = made.on_initialize() if is_initialised else None
    except RtkitError:
        raise
    except BaseException as error:
        what = getattr(cls, "on_initialize" if is_initialised else "__init__")
        raise Refused(f"{typed}: {describe_failure(error, what)}") from error
    if code not in (None, "RTC_OK"):
        raise Refused(f"{typed}: on_initialize returned {code}")
    return made
