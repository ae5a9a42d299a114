"""Plans a recovery: checks of what must exist, creation of what does not, then all the rest."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping

from rtkit.deployment.actions import Attach, Create, Load
from rtkit.deployment.facts import Snapshot
from rtkit.deployment.layered_plan import Check, Layer, LayeredPlan, PlannedAction, layer
from rtkit.deployment.live_index import LiveIndex, absence
from rtkit.deployment.system import BadComponent, WantedComponent, WantedSystem
from rtkit.deployment.wiring import wiring_plan
from rtkit.errors import Malformed, NotFound
from rtkit.rtc.create import FRESH_SLAVE, parse_create
from rtkit.rtc.names import check_instance_name
from rtkit.rtc.profiles import ModuleProfile, split_module

NOTHING_LACKS: Mapping[str, str] = {}


def bring_up_plans(
    system: WantedSystem,
    before: Snapshot,
    look: Callable[[], LiveIndex] | None = None,
    *,
    may_create: bool = True,
    lacks: Mapping[str, str] = NOTHING_LACKS,
) -> Iterator[LayeredPlan]:
    """Yield the plan that creates components, then the plan of all the rest.

    `look` returns what lives once the first plan is carried out. Without it, in a dry run, the
    second plan takes for granted that everything was created. `lacks` states why some cannot be.

    Raises:
        RtkitError: A component cannot be made as it is wanted.
    """
    live = LiveIndex(before, system)
    creation = creation_plan(system, live, may_create=may_create, lacks=lacks)
    yield creation
    if look is None:
        yield wiring_plan(system, live, creation.made)
    else:
        yield wiring_plan(system, live if creation.is_done else look())


def creation_plan(
    system: WantedSystem,
    live: LiveIndex,
    *,
    may_create: bool = True,
    lacks: Mapping[str, str] = NOTHING_LACKS,
) -> LayeredPlan:
    """Return the checks of what must be there, and the creation of what is not.

    `lacks` states why components, by name, cannot be made.

    Raises:
        NotFound: A component that is to be made names a host that nobody knows.
        BadComponent: A component that is to be made has a name that none may bear.
    """
    missing = [c for c in system.components if may_create and _is_to_be_made(c, live)]
    for component in missing:
        try:
            check_instance_name(component.instance)
        except Malformed as error:
            raise BadComponent(system.components.index(component), str(error)) from error
    pending = {c.instance for c in missing}
    unmakable = {c.instance for c in system.components if may_create and not live.create_of(c)}
    return LayeredPlan(
        (*checks(system, live, pending, unmakable), *_lacking(missing, lacks)),
        (
            *layer("load", _loads([c for c in missing if c.instance not in lacks], live)),
            *_creations(missing, live, lacks),
            *layer("attach", _attachments(system, live)),
        ),
    )


def _lacking(missing: Iterable[WantedComponent], lacks: Mapping[str, str]) -> Iterator[Check]:
    """Yield the checks of required components that cannot be made; others are left out."""
    for component in missing:
        why = lacks.get(component.instance)
        if why and component.is_required:
            text = f'Check that component "{component.id}", "{component.instance}" can be made'
            yield Check(text, f"{component.path}: {why}")


def _creations(
    missing: Iterable[WantedComponent], live: LiveIndex, lacks: Mapping[str, str]
) -> Iterator[Layer]:
    """Yield the creation of all at once, then that of composites, inner ones first."""
    members = {c.instance: parse_create(live.create_of(c)).members for c in missing}
    left = {c.instance: c for c in missing}
    name = "create"
    while left:
        ready = [c for i, c in left.items() if not any(m in left for m in members[i] if m != i)]
        ready = ready or list(left.values())  # in a circle: the manager reports what is wrong
        left = {instance: c for instance, c in left.items() if c not in ready}
        yield from layer(name, [_creation(c, live, lacks.get(c.instance)) for c in ready])
        name = "compose"


def _attachments(system: WantedSystem, live: LiveIndex) -> Iterator[PlannedAction]:
    """Yield who is to be driven by a context of another; needed by none, as they need not be."""
    for component in system.components:
        facts = live.at(component.instance)
        driven = {c.id: c.participants for c in facts.contexts} if facts is not None else {}
        for context, guest in component.guests:
            text = f"Attach {guest} to execution context {context} of component {component.path}"
            if guest in driven.get(context, ()):
                yield PlannedAction(text, None, holds=True)
            else:
                attach = Attach(component.instance, context, guest)
                yield PlannedAction(text, attach, where=component.path)


def checks(
    system: WantedSystem,
    live: LiveIndex,
    pending: Collection[str] = (),
    unmakable: Collection[str] = (),
) -> Iterator[Check]:
    """Yield what must hold before connections are made; `pending` are components to be made."""
    yield from component_checks(system, live, pending, unmakable)
    seen = set()
    for connector in system.connectors:
        for end in connector.profile.ports if connector.is_required else ():
            if end in seen:
                continue
            seen.add(end)
            component = system.component(end.instance)
            facts = live.at(end.instance)
            failure = ""
            # A missing or different component is reported itself, and nothing of its ports.
            is_there = end.instance not in pending and not absence(component, live)
            if is_there and facts is not None and facts.port(end.port) is None:
                failure = f"Required port not found: {end.port} (on {component.path})"
            text = f'Check for required port "{end.port}" on component at path {component.path}'
            yield Check(text, failure)


def component_checks(
    system: WantedSystem,
    live: LiveIndex,
    pending: Collection[str] = (),
    unmakable: Collection[str] = (),
) -> Iterator[Check]:
    """Yield the checks of required components; of the `unmakable` nobody knows how to make one."""
    for component in system.components:
        if not component.is_required:
            continue
        failure = "" if component.instance in pending else absence(component, live)
        if failure and component.instance in unmakable and live.entry(component.instance) is None:
            failure += " (nothing tells how to make it; --stand-in generates it)"
        yield Check(
            f'Check for required component "{component.id}", "{component.instance}"'
            f" at path {component.path}",
            failure,
        )


def _is_to_be_made(component: WantedComponent, live: LiveIndex) -> bool:
    entry = live.entry(component.instance)
    if entry is not None and (not entry.zombie or entry.instance != component.instance):
        return False
    other = live.namesake(component.instance)
    if other is not None and not other.zombie:
        return False
    if not live.create_of(component):
        return False
    if component.unknown_host:
        raise NotFound(
            f"no such host: {component.unknown_host} (component {component.instance});"
            f" --map {component.unknown_host}=localhost makes it here"
        )
    return True


def _loads(missing: list[WantedComponent], live: LiveIndex) -> Iterator[PlannedAction]:
    required: dict[tuple[str, str], bool] = {}
    for component in missing:
        if component.module and component.pattern is None:
            key = (component.manager, component.module)
            required[key] = required.get(key, False) or component.is_required
    for (manager, module), is_required in required.items():
        path, init = split_module(module)
        loaded = live.managers[manager or live.snapshot.manager].modules
        holds = any(is_loaded(known, path, init) for known in loaded)
        action = None if holds else Load(path, init, manager)
        where = f" on {manager}" if manager else ""
        yield PlannedAction(f'Load module "{module}"{where}', action, is_required, holds=holds)


def is_loaded(known: ModuleProfile, path: str, init: str) -> bool:
    """Return whether a loaded module is the one of a path, and of an init function if named."""
    return known.is_at(path) and init in ("", known.init)


def _creation(component: WantedComponent, live: LiveIndex, lack: str | None) -> PlannedAction:
    create = live.create_of(component)
    place = parse_create(create).place
    manager = f"manager {component.manager}" if component.manager else "the manager"
    where = f"in slave {place}" if place else f"in {manager}"
    if place == FRESH_SLAVE:
        where = "in a slave of its own"
    if place and component.manager:
        where += f" on {component.manager}"
    text = f'Create component "{component.id}", "{component.instance}" at path {component.path}'
    action = None if lack else Create(create, (component.name,), component.pattern)
    blocked = f"{component.path}: {lack}" if lack else ""
    return PlannedAction(
        f"{text} {where}", action, component.is_required, blocked, where=component.path
    )
