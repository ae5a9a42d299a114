"""Client of a manager: one round trip for facts, one for actions."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from rtkit import fault
from rtkit.closing import Closing
from rtkit.errors import Malformed, Refused, Unreachable
from rtkit.link import zenoh_keys
from rtkit.rtc.names import LOCAL
from rtkit.tree.api import ByPath, as_text

if TYPE_CHECKING:
    from rtkit.deployment.actions import Action, Result
    from rtkit.deployment.delta import FullSnapshot
    from rtkit.deployment.facts import Snapshot
    from rtkit.deployment.listing import Listing
    from rtkit.deployment.port_samples import PortName, Sample
    from rtkit.deployment.terminal import TerminalAnswer
    from rtkit.link.devices import HostFacts
    from rtkit.link.transport import Link
    from rtkit.rtc.names import Path

DEFAULT_TIMEOUT_S = 10.0
_CREATE = "create_component"
"""An operation that makes another thing each time: it bears an id, like batches."""
_GRACE_S = 1.0
_LONGEST_S = 7 * 86_400.0
_MOST_IN_A_PART = 50


class Tree(ByPath, Closing):
    """A connection to one manager, through which everything it knows is read and changed.

    For scripts: `ls component create delete activate deactivate reset connect disconnect`, which
    take paths; `get` and `set` of the manager's properties; `close`, or a
    ``with`` block. The others speak the manager's own language: facts of `rtkit.deployment.facts`,
    actions of `rtkit.deployment.actions`.

    Attributes:
        link: Link that carries the calls.
        host: Host name of the manager.
        manager: Its name.
        timeout_s: Bound on every call [s].
        has_ended: Whether the manager's process is known to have ended.
        place: What paths to it begin with: ``localhost``, the name of its host, or its address.
        on_start: Is called with a manager that is started, before any request to it.
        ticks: The actions of `tick` by path and context.
    """

    def __init__(
        self, link: Link, host: str, manager: str, timeout_s: float = DEFAULT_TIMEOUT_S
    ) -> None:
        self.link = link
        self.host = host
        self.manager = manager
        self.timeout_s = timeout_s
        self.has_ended: Callable[[], bool] = lambda: False
        self.place = LOCAL
        self.on_start: Callable[[Tree], object] = lambda _tree: None
        self.ticks: dict[tuple[str, int | str], Action] = {}
        self._service = zenoh_keys.service(host, manager)

    def __repr__(self) -> str:
        return f"<Tree: manager {self.manager!r} on {self.host}>"

    def close(self) -> None:
        """End the connection."""
        self.link.close()

    def _manager_at(self, _path: Path) -> str:
        """Return the other manager that a path leads to, empty for this one; see `DataTree`."""
        return ""

    def led_to(self, path: Path) -> Tree:
        """Return the connection to the manager that a path leads to; see `DataTree`."""
        del path
        return self

    def listing(self) -> Listing:
        """Return the short list of components.

        Raises:
            Unreachable: The manager does not answer in time.
        """
        from rtkit.deployment.listing import listing_from_text

        return listing_from_text(self.view("listing"))

    def listing_at(self, paths: Sequence[Path]) -> Listing:
        """Return a listing with the components at a few paths, and perhaps others.

        For `rtkit.tree.resolve.nodes_at`.

        Raises:
            Unreachable: The manager does not answer in time.
            NotFound: It is of a version that cannot report it.
        """
        from rtkit.deployment.listing import listing_from_text

        which = "\n".join("/".join(path.elements) for path in paths)
        return listing_from_text(self.view(f"listing/{zenoh_keys.escape(which)}"))

    def snapshot(self) -> Snapshot:
        """Return everything that the manager knows.

        Raises:
            Unreachable: The manager does not answer in time.
        """
        return self._snapshot("snapshot")

    def at(self, manager: str) -> Tree:
        """Return the connection to one of the managers in use; here there is only one."""
        return self

    def start_manager(self, manager: str) -> None:
        """Start a manager that does not run; this connection cannot.

        Raises:
            Refused: It cannot; names one that can.
        """
        raise Refused(f"manager {manager} does not run; start it with: rtmgr start {manager}")

    def end_started(self) -> list[str]:
        """End the managers that were started; return those that hold something and run on."""
        return []

    def remains(self) -> Snapshot:
        """Return what can still be seen after a failure.

        Raises:
            Unreachable: The manager does not answer in time.
        """
        return self.snapshot()

    def part(self, instances: Sequence[str]) -> Snapshot:
        """Return what concerns a few components, or with none only the manager itself.

        Their connectors are included too, and of who is at the other ends identity and names.

        Raises:
            Unreachable: The manager does not answer in time.
        """
        if len(instances) > _MOST_IN_A_PART:
            return self.snapshot()
        return self._snapshot(f"part/{zenoh_keys.escape(','.join(instances))}")

    def _snapshot(self, name: str) -> Snapshot:
        from rtkit.deployment.facts import Snapshot
        from rtkit.rtc.serde import decode

        return decode(Snapshot, self._plain(name))

    def plain(self, instances: Sequence[str] | None = None) -> dict[str, Any]:
        """Return what `part` returns, or without instances `snapshot`, as the plain data it is.

        For whom the records are too heavy: fields that hold their default are left out.

        Raises:
            Unreachable: The manager does not answer in time.
        """
        if instances is None or len(instances) > _MOST_IN_A_PART:
            return self._plain("snapshot")
        return self._plain(f"part/{zenoh_keys.escape(','.join(instances))}")

    def _plain(self, name: str) -> dict[str, Any]:
        import json

        text = self.view(name)
        try:
            return dict(json.loads(text))
        except (TypeError, ValueError) as error:
            raise Malformed(f"the manager's snapshot cannot be read: {error}") from error

    def dump(self) -> str:
        """Return the last events of the manager, as the text of a dump.

        Raises:
            Unreachable: The manager does not answer in time.
        """
        return self.view("dump")

    def past_events(self, instance: str) -> list[tuple[float, str, str, str]]:
        """Return the last events about a component: time [s since 1970], event, subject, detail.

        Raises:
            Unreachable: The manager does not answer in time.
            NotFound: It is of a version that cannot report them.
        """
        import json

        text = self.view(f"events/{zenoh_keys.escape(instance)}")
        try:
            rows = json.loads(text)
            return [
                (float(at), str(event), str(about), str(more)) for at, event, about, more in rows
            ]
        except (TypeError, ValueError) as error:
            raise Malformed(f"the manager's answer cannot be read: {error}") from error

    def port_samples(self, ports: Sequence[PortName]) -> dict[PortName, Sample]:
        """Return what some ports carry, by instance and port; see `rtkit.deployment.port_samples`.

        Last values are known from the first time on that they are asked for, for some seconds.

        Raises:
            Unreachable: The manager does not answer in time.
            NotFound: It is of a version that cannot report it.
        """
        from rtkit.deployment.port_samples import SAMPLES, ports_to_text, samples_from_text

        return samples_from_text(self.view(SAMPLES, ports_to_text(ports)))

    def ask_terminal(self, question: Mapping[str, Any]) -> TerminalAnswer:
        """Ask the terminal of a component; see `rtkit.deployment.terminal`.

        Raises:
            NotFound: There is no such component; or the manager is of a version without terminals.
            Unreachable: The manager, or the process of the component, does not answer in time.
        """
        import json

        from rtkit.deployment.terminal import TERMINAL, answer_from_text

        key = zenoh_keys.extension_key(self._service, TERMINAL)
        bound_s = self.timeout_s + float(question.get("wait_s", 0.0))
        return answer_from_text(self._ask(key, json.dumps(question), bound_s))

    def lacking(self, makings: Sequence[tuple[str, str]]) -> list[str]:
        """Return for each pair of a module and a create string why nothing can be made of it.

        Empty means that nothing speaks against it. No code is run. A module is ``PATH:INIT``, or
        empty where the type is found by its name.

        Raises:
            Unreachable: The manager does not answer in time.
            NotFound: It is of a version that cannot report it.
        """
        import json

        if not makings:
            return []
        try:
            reasons = json.loads(self.view("lacking", json.dumps(makings)))
            return [str(why) for _, why in zip(makings, reasons, strict=True)]
        except (TypeError, ValueError) as error:
            raise Malformed(f"the manager's answer cannot be read: {error}") from error

    def host_facts(self, devices: Sequence[str] = ()) -> HostFacts:
        """Return what the host of the manager has, of some devices those that are there.

        Raises:
            Unreachable: The manager does not answer in time.
            NotFound: It is of a version that cannot report it.
        """
        import json

        from rtkit.link.devices import HostFacts
        from rtkit.rtc.serde import decode_text

        return decode_text(HostFacts, self.view("host", json.dumps([*devices])))

    def apply(
        self, actions: Sequence[Action], *, is_ordered: bool = True, timeout_s: float | None = None
    ) -> tuple[Result, ...]:
        """Have the manager perform a batch and return the result of each action.

        In order, actions after a failure are not done and have no result; else all are tried.

        Raises:
            Unreachable: The manager does not answer in time.
        """
        return self.begin(actions, is_ordered=is_ordered, timeout_s=timeout_s)()

    def begin(
        self, actions: Sequence[Action], *, is_ordered: bool = True, timeout_s: float | None = None
    ) -> Callable[[], tuple[Result, ...]]:
        """Send a batch and return what awaits its results; see `apply`.

        Batches that one thread begins are taken up in that order.
        """
        from rtkit.deployment.batch import Batch, batch_to_text, results_from_text

        bound = self.timeout_s if timeout_s is None else timeout_s
        batch = Batch(tuple(actions), is_ordered, bound, request_id())
        rounds = len(batch.actions) if is_ordered else 1
        key = zenoh_keys.property_key(self._service, "batch")
        answer = self._send(key, batch_to_text(batch), bound * rounds)
        return lambda: results_from_text(answer())

    def perform(self, action: Action, *, timeout_s: float | None = None) -> str:
        """Perform one action and return what it made.

        Raises:
            RtkitError: The action failed; the class states how.
        """
        (result,) = self.apply((action,), timeout_s=timeout_s)
        result.raise_for_error()
        return result.value

    def plan_lock(self, request: Mapping[str, Any] | None = None) -> str:
        """Ask for the lock of the manager, give it back, or name its holder.

        For `rtkit.tree.plan_locks`; see `rtkit.deployment.plan_lock`.

        Raises:
            Refused: Somebody has it; names the holder.
            NotFound: The manager is of a version that has none.
            Unreachable: The manager does not answer in time.
        """
        import json

        text = json.dumps(request) if request is not None else None
        return self.view("lease", text)

    @property
    def trees(self) -> dict[str, Tree]:
        """The connections by their managers; here there is only one."""
        return {self.manager: self}

    def full_snapshot(self) -> FullSnapshot:
        """Return all facts, and the number of the last delta in them.

        Raises:
            Unreachable: The manager does not answer in time.
        """
        from rtkit.deployment.delta import FullSnapshot
        from rtkit.rtc.serde import decode_text

        return decode_text(FullSnapshot, self.view("picture"))

    def listen(self, line: str, receive: Callable[[str], object]) -> Callable[[], object]:
        """Have `receive` called with what the manager sends on a topic; return what ends that.

        For `rtkit.tree.subscription`; it is called on threads of the transport.
        """
        return self.link.listen(zenoh_keys.line_key(self._service, line), receive)

    def notice(self, found: Callable[[bool], object]) -> Callable[[], object]:
        """Have `found` told whether the manager can be asked, as it changes; return what ends that.

        For `rtkit.tree.subscription`; it is called on any thread.
        """
        return self.link.notice(zenoh_keys.property_key(self._service, "manager.pid"), found)

    def get(self, name: str) -> str:
        """Return the value of a property of the manager: ``tree.get("naming.formats")``.

        Raises:
            NotFound: No such property.
        """
        return self._ask(zenoh_keys.property_key(self._service, as_text(name, "a property's name")))

    def set(self, name: str, value: str, *, timeout_s: float | None = None) -> str:
        """Set a property of the manager and return its answer.

        Raises:
            NotFound: No such property.
            Refused: It cannot be changed now.
        """
        key = zenoh_keys.property_key(self._service, as_text(name, "a property's name"))
        if name == _CREATE:
            key += f"?id={request_id()}"
        return self._ask(key, as_text(value, f"value of {name}"), timeout_s)

    def view(self, name: str, payload: str | None = None) -> str:
        """Ask for a view of what the manager knows, beside its properties."""
        return self._ask(zenoh_keys.extension_key(self._service, name), payload)

    def _ask(self, key: str, payload: str | None = None, timeout_s: float | None = None) -> str:
        return self._send(key, payload, timeout_s)()

    def _send(
        self, key: str, payload: str | None, timeout_s: float | None = None
    ) -> Callable[[], str]:
        is_change = payload is not None
        bound = (self.timeout_s if timeout_s is None else timeout_s) + _GRACE_S * is_change

        def answer() -> str:
            with self._naming_manager(is_change):
                value = reply().value()
            fault.point("command.answered")
            return value

        fault.point("command.asking")
        with self._naming_manager(is_change):
            reply = self.link.send(key, payload, bounded(bound))
        fault.point("command.asked")
        return answer

    @contextmanager
    def _naming_manager(self, is_change: bool) -> Iterator[None]:
        """Name the manager that could not be reached."""
        try:
            yield
        except Unreachable as error:
            if self.has_ended():
                message = f"manager {self.manager!r} ended before it answered"
                unsure = "; whether it did what was asked shows when it is started again"
                raise Unreachable(message + unsure * is_change) from error
            raise Unreachable(f"{self.manager} on {self.host}: {error}") from error


def request_id() -> str:
    """Return an id for one request, which states its age to the manager."""
    from rtkit.deployment.batch import stamped_id
    from rtkit.link.deadline import boot_id

    now_us = time.clock_gettime_ns(time.CLOCK_BOOTTIME) // 1000
    return stamped_id(boot_id(), now_us, os.urandom(4).hex())


def bounded(timeout_s: float) -> float:
    """Return a time-out that transports and selectors take: neither infinity nor no number [s]."""
    return timeout_s if timeout_s < _LONGEST_S else _LONGEST_S
