"""The component of a data tool: what it hands over, and when."""

from __future__ import annotations

from rtkit.component import Time, TimedLong
from rtkit.component.values.codec import codec_for
from rtkit.probe.probe import Tool
from rtkit.probe.tap import Tap
from rtkit.rtc.profiles import ConnectorProfile, PortRef

ENCODE = codec_for(TimedLong).encode
WIRE = ConnectorProfile("w", "w", (PortRef("A", "out"), PortRef("t", "s")), {})


def handed_over(rate: float) -> list[list[int]]:
    tool = Tool("t", [Tap("s", {"dataport.inport.buffer.length": "16"})], rate)
    sink = tool.ports["s"].open(WIRE)  # type: ignore[attr-defined]
    for numbers in ((1, 2, 3), (), (4,)):
        for number in numbers:
            sink(ENCODE(TimedLong(Time(), number)))
        tool.on_execute("0")
    pieces = []
    while not tool.arrived.empty():
        piece = tool.arrived.get()
        pieces.append([codec_for(TimedLong).decode(each.payload).data for each in piece])
    return pieces


def test_everything_as_it_comes() -> None:
    assert handed_over(0.0) == [[1, 2, 3], [4]]


def test_at_a_rate_the_newest() -> None:
    assert handed_over(10.0) == [[3], [4]]
