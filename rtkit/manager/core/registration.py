"""Under which names a component is registered: those asked for, else what the templates give."""

from __future__ import annotations

from collections.abc import Iterable

from rtkit.errors import Refused
from rtkit.manager.core.state import State
from rtkit.manager.settings import formats
from rtkit.rtc.create import CreateString


def early_names(state: State, create: CreateString, instance: str) -> tuple[str, ...]:
    """Return the names of a component that is to be made, as far as they are known.

    Raises:
        Malformed: A template cannot be read.
    """
    templates = [each for each in _templates(state, create) if formats.is_early(each)]
    return formats.expand(templates, instance=instance, host=state.host, manager=state.name)


def late_names(state: State, create: CreateString, instance: str) -> tuple[str, ...]:
    """Return the further names of a component that was made.

    Raises:
        Refused: One is taken.
        Malformed: One has an empty element.
    """
    templates = [each for each in _templates(state, create) if not formats.is_early(each)]
    names = _expanded(state, templates, instance)
    check_free(state, names, instance)
    return names


def free_names(state: State, instance: str) -> tuple[str, ...]:
    """Return the names that the templates give a component that came by itself, if nobody has them.

    Raises:
        Malformed: A template cannot be read.
    """
    create = CreateString(state.components[instance].type.type_name)
    names = _expanded(state, _templates(state, create), instance)
    return tuple(name for name in names if state.name_owner(name) in ("", instance))


def _expanded(state: State, templates: Iterable[str], instance: str) -> tuple[str, ...]:
    process = state.process_of(instance)
    return formats.expand(
        templates,
        instance=instance,
        host=state.host,
        manager=state.name,
        type=state.components[instance].type,
        pid=process.pid if process is not None else 0,
    )


def check_free(state: State, names: Iterable[str], instance: str) -> None:
    """Refuse names that somebody else has.

    Raises:
        Refused: Names the first, and who has it.
    """
    for name in names:
        owner = state.name_owner(name)
        if owner and owner != instance:
            raise Refused(f"name /{name} is taken by {owner}")


def _templates(state: State, create: CreateString) -> tuple[str, ...]:
    if not state.settings.flag("naming.enable"):
        return ()
    own = create.options.get("naming.formats", "")
    return formats.check(own or state.settings.text("naming.formats"))
