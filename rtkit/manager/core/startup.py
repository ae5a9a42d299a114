"""Starts the system of a manager: loads, creates, connects, activates; reports each failure.

What follows a failure is tried all the same: the rest of a system is better than nothing of it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from rtkit.component.options import remarks
from rtkit.deployment import actions as act
from rtkit.deployment.actions import Action
from rtkit.deployment.batch import Batch, results_from_text
from rtkit.errors import Refused, RtkitError
from rtkit.manager.core.events import BatchRequested, RecoveryRequested, StartStepDone
from rtkit.manager.core.preconnect import connector
from rtkit.manager.core.requests import PendingRequests
from rtkit.manager.core.state import ManagerState
from rtkit.property.exchange import Reply
from rtkit.rtc.create import parse_create
from rtkit.rtc.enums import Transition
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

    What is done with a note goes to `warn`, or is a failure where the start is strict.
    All of it runs on the thread of the loop: `begin` is called there, and so are answers.
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
                heard = partial(self._heard, key, item)
                asked = tuple(map(act.strict, actions) if self._is_strict else actions)
                batch = Batch(asked, True, TIMEOUT_S)
                self._post(BatchRequested(batch, self._requests.add(heard)))
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

    def _heard(self, key: str, item: str, reply: Reply) -> None:
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
