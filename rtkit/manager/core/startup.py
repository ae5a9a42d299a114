"""Starts the system of a manager: loads, creates, connects, activates; reports each failure.

The start goes on after a failure: the rest of a system is better than nothing of it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from rtkit.component.ports.options import remarks
from rtkit.deployment import actions as act
from rtkit.deployment.actions import Action
from rtkit.deployment.batch import Batch, results_from_text
from rtkit.deployment.shown_ports import OwnEnds
from rtkit.errors import Malformed, NotFound, Refused, RtkitError
from rtkit.manager.core.events import BatchRequested, RecoveryRequested, StartStepDone
from rtkit.manager.core.requests import PendingRequests
from rtkit.manager.core.state import ManagerState
from rtkit.property.exchange import Reply
from rtkit.rtc.create import parse_create
from rtkit.rtc.enums import PortType, Transition
from rtkit.rtc.nearest import did_you_mean
from rtkit.rtc.port_types import are_reversed
from rtkit.rtc.profiles import ConnectorProfile, PortProfile, PortRef
from rtkit.settings import values
from rtkit.settings.properties import STRICT

TIMEOUT_S = 10.0
"""How long each action may take [s]."""

_Plan = Callable[[ManagerState, str], list[Action]]


def _load(_state: ManagerState, text: str) -> list[Action]:
    return [act.Load(file, init) for file, init in values.modules(text)]


def _create(_state: ManagerState, text: str) -> list[Action]:
    return [act.Create(str(parse_create(text)))]


def _connect(state: ManagerState, text: str) -> list[Action]:
    wire = connector(state, text)
    return [] if wire is None else [act.Connect(wire)]


def _activate(state: ManagerState, instance: str) -> list[Action]:
    facts = state.components.get(instance)
    contexts = [each.id for each in facts.contexts] if facts is not None else ["0"]
    return [act.ChangeState(instance, context, Transition.ACTIVATE) for context in contexts]


_PHASES: Sequence[tuple[str, _Plan]] = (
    ("manager.preload.modules", _load),
    ("manager.modules.preload", _load),
    ("manager.components.precreate", _create),
    ("manager.components.preconnect", _connect),
    ("manager.components.preactivation", _activate),
)


class StartUp:
    """Hands in one batch after the other; `done` is called with the failures, by name.

    Notes about what is done go to `warn`, or are failures where the start is strict. All of it runs
    on the thread of the loop: `begin` is called there, and so are answers.
    """

    def __init__(
        self,
        state: ManagerState,
        requests: PendingRequests,
        post: Callable[[BatchRequested | RecoveryRequested | StartStepDone], object],
        done: Callable[[list[tuple[str, str]]], object],
        warn: Callable[[str], object],
    ) -> None:
        self._state = state
        self._requests = requests
        self._post = post
        self._done = done
        self._warn = warn
        self._is_strict = state.settings.flag(STRICT)
        self._failures: list[tuple[str, str]] = []
        self._steps = [
            (key, plan, item) for key, plan in _PHASES for item in state.settings.items(key)
        ]

    def restore(self) -> None:
        """Have the desired state of an earlier manager recovered, then begin."""
        self._post(RecoveryRequested(self._requests.add(self._restored)))

    def _restored(self, reply: Reply) -> None:
        for result in results_from_text(reply.value()):
            self._fail("restore", result.value, result.why)
        self.begin()

    def begin(self) -> None:
        """Do the next thing, or report that nothing is left."""
        while self._steps:
            key, plan, item = self._steps.pop(0)
            if f"{key}: {item}" in self._state.kept.begun:
                continue  # done by an earlier manager, and perhaps undone by its user since
            try:
                actions = plan(self._state, item)
                self._look_at(key, item, actions)
            except RtkitError as error:
                self._fail(key, item, str(error))
                continue
            if actions:
                on_reply = partial(self._on_reply, key, item)
                asked = tuple(map(act.strict, actions) if self._is_strict else actions)
                batch = Batch(asked, True, TIMEOUT_S)
                self._post(BatchRequested(batch, self._requests.add(on_reply)))
                return
        self._done(self._failures)

    def _look_at(self, key: str, item: str, actions: Sequence[Action]) -> None:
        """Warn of what is not known in the properties of connectors that are to be made.

        Raises:
            Refused: There is something, and the start is strict.
        """
        odd = [
            text
            for action in actions
            if isinstance(action, act.Connect)
            for text in remarks(action.connector.properties)
        ]
        if odd and self._is_strict:
            raise Refused("; ".join(odd))
        for text in odd:
            self._warn(f"{key}: {item}: {text}")

    def _on_reply(self, key: str, item: str, reply: Reply) -> None:
        try:
            for result in results_from_text(reply.value()):
                result.raise_for_error()
                if result.note:
                    self._warn(f"{key}: {item}: {result.note}")
            self._post(StartStepDone(f"{key}: {item}"))
        except RtkitError as error:
            self._fail(key, item, str(error))
        self.begin()

    def _fail(self, key: str, item: str, why: str) -> None:
        self._failures.append((f"{key}: {item}", why))


_DEFAULTS = {
    "dataport.dataflow_type": "push",
    "dataport.interface_type": "zenoh",
    "dataport.subscription_type": "new",
}
_OWN = ("dataport.", "port.", "rtkit.")


def connector(state: ManagerState, text: str) -> ConnectorProfile | None:
    """Return the connector to be made, None when the ports are connected already.

    Raises:
        Malformed: The text cannot be read.
        NotFound: A port is not there.
    """
    options = dict(parse_create(text).options)
    other = options.pop("port", "")
    if not other:
        raise Malformed(f"not COMPONENT.PORT?port=COMPONENT.PORT: {text}")
    one_ref, one = _port(state, text.partition("?")[0])
    other_ref, its = _port(state, other)
    ends = (one_ref, other_ref)
    if are_reversed((one.port_type, its.port_type)):
        ends = (other_ref, one_ref)
    if any(set(connector.ports) == set(ends) for connector in state.connectors.values()):
        return None
    given = {key if key.startswith(_OWN) else f"dataport.{key}": v for key, v in options.items()}
    if one.port_type is PortType.SERVICE:
        properties = {"port.port_type": PortType.SERVICE.value, **given}
    else:
        data_type = one.data_type or its.data_type
        properties = {**_DEFAULTS, "dataport.data_type": data_type, **given}
    name = "_".join(end.port for end in ends)
    return ConnectorProfile("-".join(map(str, ends)), name, ends, properties)


def _port(state: ManagerState, text: str) -> tuple[PortRef, PortProfile]:
    """Find a port by ``COMPONENT.PORT``; both names may have dots."""
    parts = text.split(".")
    for index in range(len(parts) - 1, 0, -1):
        facts = state.components.get(".".join(parts[:index]))
        port = facts.port(".".join(parts[index:])) if facts is not None else None
        if port is not None:
            ref = PortRef(".".join(parts[:index]), port.name)
            return OwnEnds(state.components).end(ref), port
    known = [f"{name}.{port.name}" for name, c in state.components.items() for port in c.ports]
    raise NotFound(f"no such port: {text}{did_you_mean(text, known)}")
