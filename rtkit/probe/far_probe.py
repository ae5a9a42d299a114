"""Reads and writes ports of a manager that is reached over TLS, by a tap of its own host.

See `rtkit.probe.far_tap`; to data tools it is a `Probe`.
"""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from queue import Empty, Queue, SimpleQueue
from typing import TYPE_CHECKING, Any, cast

from rtkit.component.ports.any_port import Port
from rtkit.component.values.codec import codec_for
from rtkit.errors import Refused, RtkitError
from rtkit.link.tap_messages import ENDED, Value, values_from_bytes, values_to_bytes
from rtkit.link.threads import start_thread
from rtkit.probe.port_spec import Stream
from rtkit.probe.probe import LOSSLESS, Probe, Refusal, no_connection
from rtkit.probe.tap import Arrival
from rtkit.tree.client import Tree
from rtkit.tree.connect import connect

if TYPE_CHECKING:
    from rtkit.tree.secure_link import SecureLink

_PAUSE_S = 0.005
"""Time between two requests of a kind: an endpoint takes a bounded number of them a second [s]."""
_PIECE_BYTES = 1 << 20
_MOST_WAITING = 4096
_FLUSH_S = 10.0


class _FarTool:
    """The component there, as far as tools see it; see `rtkit.probe.probe.Tool`."""

    def __init__(self) -> None:
        self.instance = ""
        self.arrived: SimpleQueue[list[Arrival]] = SimpleQueue()
        self.notify: Callable[[], object] = lambda: None


class FarProbe(Probe):
    """A probe at a manager that is reached over TLS.

    Args:
        tree: The manager.
        kind: Of the component, before its number.
        streams: Its ports.
        rate: See `Probe`.
        writes: It writes values.
    """

    def __init__(
        self, tree: Tree, kind: str, streams: Sequence[Stream], rate: float, *, writes: bool
    ) -> None:
        # Of its own: a connection has one tap, which ends with it.
        self._own = connect(tree.place, tree.timeout_s)
        self._timeout_s = tree.timeout_s
        self._kind = kind
        self._rate = rate
        self._writes = writes
        self._wanted = streams
        self._names = [each.name for each in streams]
        self._ahead_ns = round(streams[0].clock.offset_s * 1e9) if streams else 0
        self._ended = threading.Event()
        self._error: RtkitError | None = None
        self._to_write: Queue[Value] = Queue(_MOST_WAITING)
        self._is_closed = False
        self.is_patient = False
        self.component = _FarTool()  # type: ignore[assignment]

    def connect(self, properties: Mapping[str, str], refused: Refusal | None = None) -> None:
        """See `Probe.connect`."""
        asked = {
            "kind": self._kind,
            "rate": self._rate,
            "writes": self._writes,
            "lossless": properties == LOSSLESS,
            "is_patient": refused is not None,
            "streams": _named(self._wanted),
        }
        self.component.instance, why = self._call("open", asked)
        for each in why:
            (refused or self._fail)(each)
        start_thread(self._send_values if self._writes else self._take_values, "tap")

    def extend(self, ports: Sequence[Port]) -> None:
        """See `Probe.extend`."""
        self._names += [each.name for each in ports]
        self._ask("extend", json.dumps([each.name for each in ports]).encode())

    def join(self, tree: Tree, streams: Sequence[Stream], refused: Refusal) -> None:
        """See `Probe.join`."""
        self._names += [each.name for each in streams if each.name not in self._names]
        for why in self._call("join", _named(streams)):
            refused(why)

    @property
    def lost(self) -> int:
        """See `Probe.lost`."""
        return int(json.loads(self._ask("lost", b"")))

    def check_connected(self) -> None:
        """See `Probe.check_connected`."""
        if self._ended.is_set() and not self.is_patient:
            raise self._error or no_connection()

    def take(self, until: float | None) -> list[Arrival] | None:
        """See `Probe.take`."""
        piece = super().take(until)
        if piece is None and self._error is not None:
            raise self._error
        return piece

    def write(self, port: str, value: Any) -> None:
        """See `Probe.write`; it waits where many values are on the way."""
        payload = value if isinstance(value, bytes) else codec_for(type(value)).encode(value)
        self._check()
        self._to_write.put((self._names.index(port), 0, payload))

    def flush(self) -> None:
        """See `Probe.flush`."""
        self._to_write.join()
        self._check()
        self._ask("flush", b"", _FLUSH_S)

    def close(self) -> None:
        """End the tap, which ends with the connection, and with it what still waits."""
        self._is_closed = True
        self.stop()
        self._own.close()

    def _check(self) -> None:
        if self._error is not None:
            raise self._error

    def _fail(self, why: str) -> None:
        raise Refused(why)

    def _call(self, word: str, asked: object) -> Any:
        return json.loads(self._ask(word, json.dumps(asked).encode()))

    def _ask(self, word: str, body: bytes, timeout_s: float | None = None) -> bytes:
        link = cast("SecureLink", self._own.link)
        return link.ask_tap(word, body, timeout_s or self._timeout_s)()

    def _take_values(self) -> None:
        """Take what arrives there, on a thread of its own."""
        try:
            while not self._is_closed:
                data = self._ask("take", b"")
                values = values_from_bytes(data[1:])
                arrivals = [Arrival(self._names[n], at - self._ahead_ns, v) for n, at, v in values]
                if arrivals:
                    self.component.arrived.put(arrivals)
                    self.component.notify()
                if data[:1] == ENDED:
                    break
                time.sleep(_PAUSE_S)
        except (ValueError, IndexError) as error:
            self._error = Refused(f"what the tap sends is no sense: {error}")
        except RtkitError as error:
            self._error = error
        self.stop()

    def _send_values(self) -> None:
        """Send what is written, several values at a time, on a thread of its own."""
        while not self._is_closed:
            values = list(self._waiting_values())
            try:
                if values and self._error is None:
                    self._ask("write", values_to_bytes(values))
            except RtkitError as error:
                self._error = error
                self.stop()
            for _ in values:
                self._to_write.task_done()
            time.sleep(_PAUSE_S)

    def _waiting_values(self) -> Iterable[Value]:
        size = 0
        while size < _PIECE_BYTES:
            try:
                value = self._to_write.get(timeout=0.0 if size else 0.25)
            except Empty:
                return
            size += len(value[2]) + 1
            yield value


def _named(streams: Iterable[Stream]) -> list[tuple[str, list[tuple[str, str, str]]]]:
    return [
        (each.name, [(end.ref.instance, end.ref.port, end.path.typed) for end in each.ends])
        for each in streams
    ]
