"""Tells what ports of this process carry: counters, last values, and how full their buffers are."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from itertools import islice
from time import monotonic
from typing import Any

from rtkit.component.base import Component
from rtkit.component.ports.in_port import InPort
from rtkit.component.ports.out_port import OutPort
from rtkit.container.operations import LATER, Operations
from rtkit.deployment.message import Message
from rtkit.deployment.port_samples import MOST_NUMBERS, MOST_TEXT, SAMPLES, PortName


def sampling(components: Mapping[str, Component], send: Callable[[Message], object]) -> Operations:
    """Return the operation that sends samples of ports of some components."""

    def sample(message: Message) -> object:
        samples = samples_of(components, message["ports"])
        send({SAMPLES: samples, "number": message["number"]})
        return LATER

    return {SAMPLES: sample}


def samples_of(components: Mapping[str, Component], ports: Iterable[PortName]) -> list[list[Any]]:
    """Return instance, port and sample of each port that is there and carries data.

    Looking begins, or renews, a watch of the port: a value that came before the first look is not
    known.
    """
    found = []
    for instance, name in ports:
        component = components.get(instance)
        port = component.ports.get(name) if component is not None else None
        if isinstance(port, InPort | OutPort):
            found.append([instance, name, _sample(port)])
    return found


def _sample(port: InPort[Any] | OutPort[Any]) -> dict[str, Any]:
    watch = port.watch()
    if isinstance(port, OutPort):
        sample: dict[str, Any] = {"count": port.written}
    else:
        sample = {"count": port.read_count, "buffers": port.fills()}
    last = watch.last
    if last is not None:
        at, value = last
        if watch.shown is None or watch.shown[0] is not last:
            watch.shown = (last, _shown(value))
        sample |= {"age": monotonic() - at, **watch.shown[1]}
    return sample


def _shown(value: Any) -> dict[str, Any]:
    from rtkit.component.values.fields import numbers
    from rtkit.component.values.value_text import text_of

    text = text_of(value)
    few = islice(numbers(value), MOST_NUMBERS)
    return {
        "text": text if len(text) <= MOST_TEXT else f"{text[: MOST_TEXT - 1]}…",
        "numbers": {name: number if math.isfinite(number) else None for name, number in few},
    }
