"""Composite components: several components driven, and activated, as one.

A composite takes the execution of its members over: their own contexts stop, its context drives
them one after the other, depth first through nested composites. The composite lists ports of
members as ``INSTANCE.PORT``. The parameters ``members`` and ``exported_ports``, each a comma list,
name the members and the ports; `arrange` puts them in force.

Every change runs on the threads that tick the contexts concerned, in stages; see `_Stages`.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from typing import ClassVar

from rtkit.component.base import Component
from rtkit.component.configuration.config import DEFAULT
from rtkit.component.configuration.parameter import Parameter
from rtkit.component.contexts.context import ExecutionContext
from rtkit.component.ports.any_port import Port
from rtkit.errors import NotFound, Refused, RtkitError
from rtkit.rtc.enums import LifeCycleState, ReturnCode, Transition

Done = Callable[[RtkitError | None], object]
_PARAMETERS = ("members", "exported_ports")


class Composite(Component):
    """Drive several components as one.

    Attributes:
        composite_type: Name of this kind in profiles.
        drives: Whether its context drives its members; else it only groups them.
        resolve: Finds a component of the same process by instance name; raises `NotFound`.
    """

    vendor = "rtkit"
    category = "composite"
    version = "1.0"
    rate = 1000.0
    drives: ClassVar[bool] = True
    composite_type: ClassVar[str] = "PeriodicECShared"

    members = Parameter("", doc="Instance names of the members, in the order of execution")
    exported_ports = Parameter("", doc="INSTANCE.PORT of each port of a member that is shown")

    def __init__(self, instance: str, options: Mapping[str, str] | None = None) -> None:
        self.resolve: Callable[[str], Component] = _no_component
        super().__init__(instance, options)

    def _declare_options(self) -> None:
        given = {key: self.options[key] for key in _PARAMETERS if key in self.options}
        self.configuration.declare(DEFAULT, given)
        super()._declare_options()

    @property
    def driver(self) -> ExecutionContext:
        """The context that drives the members: that of the outermost composite around them."""
        outer: Component = self
        while isinstance(outer.composite, Composite) and outer.composite.drives:
            outer = outer.composite
        return next(iter(outer.contexts.values()))

    def on_activated(self, context: str) -> ReturnCode | None:
        """Activate every member, or none if one fails."""
        begun: list[Component] = []
        for member in self._driven():
            code, why = self.driver.perform(member, Transition.ACTIVATE)
            if code is not ReturnCode.OK:
                for each in reversed(begun):
                    self.driver.perform(each, Transition.DEACTIVATE)
                raise Refused(f"member {member.instance}: {why}")
            begun.append(member)
        return None

    def on_deactivated(self, context: str) -> ReturnCode | None:
        """Deactivate every member that is Active."""
        for member in self._driven():
            if self.driver.state_of(member) is LifeCycleState.ACTIVE:
                self.driver.perform(member, Transition.DEACTIVATE)
        return None

    def on_aborting(self, context: str) -> ReturnCode | None:
        """Deactivate the members that still work."""
        return self.on_deactivated(context)

    def arrange(self, done: Done) -> None:
        """Bring members and shown ports into line with the parameters.

        `done` gets the error that prevented that, or None, on the thread that finishes last.
        """
        try:
            wanted, ports = self.check(self.members, self.exported_ports)
        except RtkitError as error:
            done(error)
        else:
            self._become(wanted, ports, done)

    def check(
        self, members: str, exported_ports: str
    ) -> tuple[tuple[Component, ...], Mapping[str, Port]]:
        """Return the members and ports that these values of the parameters name.

        Raises:
            NotFound: There is no such component in this process, or no such port.
            Refused: A component is a member of another composite, or above this one.
        """
        if self.drives and not self.contexts:
            raise Refused(f"{self.instance} has no execution context to drive members with")
        wanted = self._wanted_members(_names(members))
        return wanted, _exported(_names(exported_ports), wanted)

    def dissolve(self, done: Done) -> None:
        """Let all members go, so that the composite can end."""
        self._become((), {}, done)

    def expel(self, member: Component, done: Done) -> None:
        """Let one member go, whatever the parameters say, and show its ports no more."""
        kept = tuple(each for each in self.member_components if each is not member)
        shown = {
            name: port
            for name, port in self.ports.items()
            if name != port.name and port not in member.ports.values()
        }
        self._become(kept, shown, done)

    @property
    def is_arranged(self) -> bool:
        """Return whether members and shown ports agree with the parameters."""
        shown = {name for name, port in self.ports.items() if name != port.name}
        names = tuple(member.instance for member in self.member_components)
        return names == _names(self.members) and shown == set(_names(self.exported_ports))

    def _driven(self) -> tuple[Component, ...]:
        return self.member_components if self.drives else ()

    def _wanted_members(self, names: Iterable[str]) -> tuple[Component, ...]:
        wanted = []
        for name in names:
            member = self.resolve(name)
            if self in _lineage(member):
                raise Refused(f"{self.instance} cannot be a member of itself: {name}")
            if member.composite not in (None, self):
                raise Refused(f"{name} is a member of {member.composite.instance} already")
            wanted.append(member)
        return tuple(wanted)

    def _become(
        self, members: tuple[Component, ...], shown: Mapping[str, Port], done: Done
    ) -> None:
        leaving = [each for each in self.member_components if each not in members]
        joining = [each for each in members if each not in self.member_components]

        def settle() -> None:
            for each in leaving:
                each.composite = None
            for each in joining:
                each.composite = self
            self.member_components = members
            own = {name: port for name, port in self.ports.items() if name == port.name}
            self.ports = {**own, **shown}
            self._prune_outer()

        if not self.drives:
            settle()
            done(None)
            return
        driver = self.driver

        def release() -> None:
            _release(driver, leaving)  # a cycle that comes before the last stage misses nobody
            self.member_components = tuple(m for m in self.member_components if m not in leaving)

        stages = _Stages(done)
        stages.add([(driver, release)])
        stages.add(_works(leaving, _awake))
        stages.add(_works(joining, _rest))
        stages.add([(driver, settle), (driver, partial(self._admit, driver, joining))])
        stages.run()

    def _prune_outer(self) -> None:
        """Remove ports from outer composites that this one shows no more."""
        outer = self.composite
        if isinstance(outer, Composite):
            there = {id(p) for member in outer.member_components for p in member.ports.values()}
            outer.ports = {
                name: port
                for name, port in outer.ports.items()
                if name == port.name or id(port) in there
            }
            outer._prune_outer()  # noqa: SLF001 - it is of this class

    def _admit(self, driver: ExecutionContext, joining: Iterable[Component]) -> None:
        is_active = driver.state_of(self) is LifeCycleState.ACTIVE
        for member in joining:
            for each in _lineage(member):
                driver.add_component(each)
        driver.order(tuple(_lineage(self)))
        for member in joining if is_active else ():
            driver.perform(member, Transition.ACTIVATE)


class PeriodicECSharedComposite(Composite):
    """Several components in one execution context, in the order of its members."""


class PeriodicStateSharedComposite(Composite):
    """Several components in one execution context; when one fails, all leave their work."""

    composite_type = "PeriodicStateShared"

    def on_state_update(self, context: str) -> ReturnCode | None:
        """Fail when a member did."""
        for member in self.member_components:
            if self.driver.state_of(member) is LifeCycleState.ERROR:
                raise Refused(f"member {member.instance} is in Error: {member.cause}")
        return None


class GroupingComposite(Composite):
    """Several components under one name; each keeps its own execution context and state."""

    composite_type = "Grouping"
    drives = False


TYPES: Mapping[str, type[Composite]] = {
    each.__name__: each
    for each in (PeriodicECSharedComposite, PeriodicStateSharedComposite, GroupingComposite)
}
"""The composite types that can be made without any module."""


_Work = tuple[ExecutionContext, Callable[[], object]]


class _Stages:
    """Work for the threads of several contexts, in stages: each begins when the last is done.

    Work of one context in one stage is done in its order. In the end `done` gets the first failure,
    or None, on the thread that finishes last.
    """

    def __init__(self, done: Done) -> None:
        self._done = done
        self._stages: list[list[_Work]] = []
        self._failure: RtkitError | None = None

    def add(self, works: Iterable[_Work]) -> None:
        """Append a stage; ignore an empty one."""
        stage = list(works)
        if stage:
            self._stages.append(stage)

    def run(self) -> None:
        """Begin."""
        if not self._stages:
            self._done(self._failure)
            return
        stage = self._stages.pop(0)
        count = itertools.count(1)

        def one(work: Callable[[], object]) -> None:
            try:
                work()
            except RtkitError as error:
                self._failure = self._failure or error
            if next(count) == len(stage):
                self.run()

        for context, work in stage:
            context.submit(partial(one, work))


def _works(
    members: Iterable[Component], work: Callable[[ExecutionContext, Component], object]
) -> Iterator[_Work]:
    """Yield the work on each own context of each member."""
    for member in members:
        for context in member.contexts.values():
            yield context, partial(work, context, member)


def _release(driver: ExecutionContext, leaving: Iterable[Component]) -> None:
    """Take members, and those nested in them, out of the context that drives them."""
    for member in leaving:
        for each in _lineage(member):
            driver.remove_component(each)


def _awake(context: ExecutionContext, member: Component) -> None:
    """Restart an own context of a former member; that of a composite drives its members again."""
    if isinstance(member, Composite) and member.drives and context is _first(member):
        for each in itertools.islice(_lineage(member), 1, None):
            context.add_component(each)
    context.start()


def _rest(context: ExecutionContext, member: Component) -> None:
    """Stop an own context of a new member."""
    if context.is_running and context.state_of(member) is LifeCycleState.ACTIVE:
        context.perform(member, Transition.DEACTIVATE)
    if isinstance(member, Composite) and context is _first(member):
        for each in itertools.islice(_lineage(member), 1, None):
            context.remove_component(each)
    context.stop()


def _first(component: Component) -> ExecutionContext:
    return next(iter(component.contexts.values()))


def _lineage(component: Component) -> Iterator[Component]:
    """Yield a component and, depth first, the members that its context drives for it."""
    yield component
    if isinstance(component, Composite) and component.drives:
        for member in component.member_components:
            yield from _lineage(member)


def _exported(names: Iterable[str], members: Iterable[Component]) -> dict[str, Port]:
    shown = {}
    for name in names:
        for member in members:
            own = name.removeprefix(f"{member.instance}.")
            if own != name and own in member.ports:
                shown[name] = member.ports[own]
                break
        else:
            raise NotFound(f"Port not found: {name}")
    return shown


def _names(text: str) -> tuple[str, ...]:
    return tuple(dict.fromkeys(name.strip() for name in text.split(",") if name.strip()))


def _no_component(instance: str) -> Component:
    raise NotFound(f"no component named {instance}")
