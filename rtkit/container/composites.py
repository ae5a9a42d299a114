"""Operations of a container on composites: changes members and shown ports, one after the other."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, TypeGuard

from rtkit.component.base import Component
from rtkit.container.operations import ContainerServices
from rtkit.errors import RtkitError

if TYPE_CHECKING:
    from rtkit.component.composite import Composite, Done

    _Change = Callable[[Done], object]


def is_composite(component: Component | None) -> TypeGuard[Composite]:
    """Return whether a component drives or groups others; imports nothing that these need."""
    return component is not None and bool(component.composite_type)


class Composites:
    """Operations on the composites of one process."""

    def __init__(self, host: ContainerServices) -> None:
        self._host = host
        self._waiting: deque[tuple[Composite, _Change, Done]] = deque()

    def arrange(self, composite: Composite, then: Done) -> None:
        """Change a composite as its parameters say, then call `then` on the container's thread."""
        composite.resolve = self._host.component
        self._enqueue(composite, composite.arrange, then)

    def part(self, component: Component, then: Callable[[], object]) -> None:
        """Take a component out of its composite, and let its own members go, then do `then`."""
        whole = component.composite
        if is_composite(whole):
            self._enqueue(
                whole,
                lambda done: whole.expel(component, done),
                lambda _error: self.part(component, then),
            )
        elif is_composite(component) and component.member_components:
            self._enqueue(component, component.dissolve, lambda _error: then())
        else:
            then()

    def _enqueue(self, composite: Composite, change: _Change, then: Done) -> None:
        self._waiting.append((composite, change, then))
        if len(self._waiting) == 1:
            self._begin()

    def _begin(self) -> None:
        composite, change, _ = self._waiting[0]
        touched = list(composite.member_components)

        def done(error: RtkitError | None) -> None:
            self._host.post(lambda: self._end(touched, error))

        change(done)

    def _end(self, touched: list[Component], error: RtkitError | None) -> None:
        composite, _, then = self._waiting.popleft()
        outer: Component | None = composite
        while outer is not None:
            touched.append(outer)
            outer = outer.composite
        for each in dict.fromkeys([*touched, *composite.member_components]):
            self._host.report(each)
        then(error)
        if self._waiting:
            self._begin()


def check_settings(component: Component, set_id: str, values: Mapping[str, str]) -> None:
    """Refuse settings that name members or ports that are not there, before they are stored."""
    if is_composite(component):
        present = {**component.configuration.sets.get(set_id, {}), **values}
        component.check(present.get("members", ""), present.get("exported_ports", ""))
