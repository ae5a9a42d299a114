"""Client of a serial line that many devices share, of which it asks one at a time: ``7.speed``.

A device that does not answer is named, its properties are ``no-service`` until it answers again,
and it costs the others no more than a short question now and then. Devices do not speak unasked:
whoever listens has them asked again and again.

See decision 63.
"""

from __future__ import annotations

import math
import select
import time
from time import monotonic

from rtkit.closing import Closing
from rtkit.link.wakeup import Wakeup
from rtkit.property.addressed import ALL, SILENT, AddressedReplies, addressed
from rtkit.property.codes import PASSING, PropertyError
from rtkit.property.line import write_request
from rtkit.property.messages import DONE, Answer, Payload, PropertyEvent
from rtkit.property.naming import parse_parameters, without_parameter
from rtkit.property.reading import read
from rtkit.property.requests import Requester
from rtkit.property.subscription import Listener, SubscriptionOptions, options_of
from rtkit.wires.serial.address import SerialAddress, SerialEnd
from rtkit.wires.serial.exchange import SerialExchange, Silence

_EVERY_S = 0.1
"""How often what is listened to is asked for, unless that is to be seldomer [s]."""
_SILENT_S = 1.0
"""How long one of several devices may take to answer, until it counts as silent [s]."""
_FIRST_PAUSE_S = 0.5
_LONGEST_PAUSE_S = 5.0
_TIMES_SENT = 3
"""How often is sent what nobody answers; with its id it acts once."""


class _Device(SerialExchange):
    """Exchange with one device of a shared line.

    Attributes:
        trouble: Why nothing is asked of it before `ask_at` [s, monotonic]; empty while it answers.
    """

    _first_patience_s = 0.1

    def __init__(self, name: str, *given: object) -> None:
        self.name = name
        super().__init__(*given)  # type: ignore[arg-type]
        self._pause_s = _FIRST_PAUSE_S
        self._has_begun = False
        self.trouble = ""
        self.ask_at = 0.0

    def _talk(self, *, has_checks: bool) -> None:
        self.has_checks = has_checks
        self._replies = AddressedReplies(self.name, has_checks=has_checks)

    def _encoded(self, message: bytes) -> bytes:
        if b"\n" in message[:-1] and not self.has_checks:
            raise PropertyError("too-large", "several lines need a check on a shared line")
        return super()._encoded(addressed(message, self.name))

    def _silence(self) -> Silence:
        return Silence(f"no answer within {self._timeout_s:g} s: device {self.name}")

    def is_due(self) -> bool:
        """Return whether it may be asked: it answers, or it is time to try again."""
        return not self.trouble or monotonic() >= self.ask_at

    def request(self, target: str, payload: Payload | None, same_as: str, until: float) -> Answer:
        """GET, or SET, unless it is silent."""
        if not self.is_due():
            return Answer(self.trouble, "no-service")
        began = monotonic()
        try:
            self._talk(has_checks=self.has_checks)  # half a line may be left, from before others
            if self.trouble or not self._has_begun:
                self.begin(self.usual_wait_s if self.trouble else math.inf)
                self._has_begun, self.trouble, self._pause_s = True, "", _FIRST_PAUSE_S
            return self.ask(target, payload, same_as, until)
        except Silence as error:
            if monotonic() - began < self._timeout_s and not self.trouble:
                return Answer(str(error), "timeout")  # so soon only the asker has given it up
            is_first = not self.trouble
            self.trouble = f"device {self.name} is silent"
            self.ask_at = monotonic() + self._pause_s
            self._pause_s = min(self._pause_s * 2, _LONGEST_PAUSE_S)
            return Answer(str(error), "timeout") if is_first else Answer(self.trouble, "no-service")

    def broadcast(self, target: str, payload: Payload) -> Answer:
        """SET at all devices, of which none answers."""
        is_checked = self.has_checks = self._settings.has_checks is not False
        target = without_parameter(target, "timeout")  # of proxies
        data = self._encoded(write_request(target, payload, self._next_id() if is_checked else ""))
        for _ in range(_TIMES_SENT if is_checked else 1):
            self._send(data, monotonic() + self._timeout_s)
        return DONE

    def wait(self, wait_s: float | None) -> None:
        """Wait to be woken; throw away what comes meanwhile."""
        while self._is_ready(select.POLLIN, wait_s, may_wake=True):
            self._read()
            wait_s = 0.0
        self._talk(has_checks=self.has_checks)


class _Watched(Listener):
    """Listener to a property that is asked for again and again."""

    __slots__ = ("_last", "ask_at")

    def __init__(self, name: str, options: SubscriptionOptions, first: Answer) -> None:
        super().__init__(name, (), options, Requester())
        self._last = PropertyEvent(name, first.payload, time.time(), 1)
        self.offer(self._last, _value(first), is_first=True)
        self.asked()

    def asked(self) -> None:
        """Note that it was asked for."""
        self.ask_at = monotonic() + max(self.options.every_s, _EVERY_S)

    def take_in(self, answer: Answer) -> None:
        """Take an answer: without one the last value is stale, or the property is gone."""
        last, quality = self._last, "stale" if answer.error in PASSING else "good"
        payload, code = (last.payload, "") if quality == "stale" else answer
        self.asked()
        if (payload, quality, code) == (last.payload, last.quality, ""):
            return
        at = last.revision + 1
        quality = "bad" if code else quality
        payload = "" if code else payload
        self._last = PropertyEvent(self.name, payload, time.time(), at, quality, 0, code)
        if quality == last.quality:
            self.offer(self._last, _value(answer))
        else:
            self.push(self._last)
        self.has_ended = bool(code)


def _value(answer: Answer) -> object:
    """Return what a deadband compares; a text that is no value differs by anything."""
    try:
        return read(str(answer.payload))
    except PropertyError:
        return None


class SharedLine(Closing):
    """Conversation with the devices of one line; `rtkit.wires.serial.client` makes it.

    Args:
        timeout_s: Bound on each request [s]; one of several devices has 1 s at most.
    """

    def __init__(self, end: SerialEnd, settings: SerialAddress, timeout_s: float) -> None:
        self._wakeup = Wakeup()
        self._end = end
        self._is_alone = len(settings.devices) == 1
        bound_s = timeout_s if self._is_alone else min(timeout_s, _SILENT_S)
        self._devices = {
            name: _Device(name, end, settings, bound_s, self._wakeup)
            for name in (*settings.devices, ALL)
        }
        self._all = self._devices[ALL]
        self._watched: dict[str, _Watched] = {}

    def ask(
        self,
        target: str,
        payload: Payload | None = None,
        same_as: str = "",
        until: float = math.inf,
    ) -> Answer:
        """See `SerialExchange.ask`; a device that is silent is an answer, ``no-service``.

        Raises:
            Unreachable: The line is gone.
            PropertyError: ``too-large``: several lines, which need a check here.
        """
        name, mark, tail = target.partition("?")
        if payload is not None and name.endswith(".listen"):
            return self._listen(name.removesuffix(".listen"), tail, payload)
        if self._is_alone:
            device, rest = next(iter(self._devices.values())), name
        else:
            first, dot, rest = name.partition(".")
            if name in ("properties", SILENT):
                return self._about_all(name, payload, tail)
            if first not in self._devices:
                return Answer(f"no such property: {name}", "unknown")
            device, rest = self._devices[first], rest if dot else "properties"
        rest = f"{rest}{mark}{tail}"
        if device is not self._all:
            return device.request(rest, payload, same_as, until)
        if payload is None:
            return Answer(f"cannot be read: {name}", "write-only")
        return self._all.broadcast(rest, payload)

    def _about_all(self, name: str, payload: Payload | None, tail: str) -> Answer:
        if payload is not None:
            return Answer(f"cannot be set: {name}", "read-only")
        if tail:
            return Answer(f"{name} of a shared line has no parameters", "bad-parameter")
        silent = [each.name for each in self._devices.values() if each.trouble]
        names = silent if name == SILENT else [*self._devices, SILENT]
        return Answer(f"({' '.join(names)})")

    # Events

    def listen(self, target: str) -> None:
        """See `PropertyClient.listen`; every 0.1 s, or seldomer (``every=``), it is asked for."""
        name, mark, tail = target.partition("?")
        self.ask(f"{name}.listen{mark}{tail}", "self").value()

    def leave(self, name: str) -> Answer:
        """Listen to a property no longer."""
        is_known = self._watched.pop(name, None) is not None
        return DONE if is_known else Answer(f"not listened to: {name}", "unknown")

    def _listen(self, name: str, tail: str, ref: Payload) -> Answer:
        if ref != "self":
            return Answer("events go to self only", "denied")
        try:
            given = parse_parameters(tail) if tail else {}
            if given.pop("remove", "false") in (None, "true", "1"):
                return self.leave(name)
            options = options_of({key: read(text or "true") for key, text in given.items()})
        except PropertyError as error:
            return Answer(str(error), error.code)
        answer = self.ask(name)
        if answer.error:
            return answer
        self._watched[name] = _Watched(name, options, answer)
        return DONE

    def wake(self) -> None:
        """Make `event` return None at once, or as soon as it is called; from any thread."""
        self._wakeup.ring()

    def event(self, timeout_s: float | None = None) -> PropertyEvent | None:
        """See `PropertyClient.event`; in between, silent devices are tried again."""
        deadline = math.inf if timeout_s is None else monotonic() + timeout_s
        while True:
            now = monotonic()
            for watched in list(self._watched.values()):
                event = watched.take(now)
                if watched.has_ended and not watched.pending:
                    del self._watched[watched.name]
                if event is not None:
                    return event
            if self._wakeup.hush() or now >= deadline:
                return None
            if not self._ask_next(now):
                dues = [each.ask_at for each in self._watched.values()]
                dues += [at for each in self._watched.values() if (at := each.due()) is not None]
                dues += [each.ask_at for each in self._devices.values() if each.trouble]
                due = min([deadline, *dues]) - now
                self._all.wait(None if due == math.inf else max(0.0, due))

    def _ask_next(self, now: float) -> bool:
        """Ask for one thing that is due; return whether there was one."""
        watched = min(self._watched.values(), key=lambda each: each.ask_at, default=None)
        if watched is not None and watched.ask_at <= now:
            watched.take_in(self.ask(watched.name))
            return True
        for device in self._devices.values():
            if device.trouble and device.is_due():
                device.request("properties", None, "", math.inf)
                return True
        return False

    def close(self) -> None:
        """End the conversation."""
        self._end.close()
        self._wakeup.close()
