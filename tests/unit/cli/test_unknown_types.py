"""Data types by their names, and what becomes of values of those that nobody defined."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from fake_manager import FakeManager
from fake_tree import fake_tree

from rtkit.api.ports import streams_of, types_of
from rtkit.cli.data.arguments import specified
from rtkit.cli.data.player import _matched
from rtkit.cli.shared.app import App
from rtkit.component import TimedLong
from rtkit.component.values.codec import codec_for
from rtkit.errors import NotFound, Refused
from rtkit.probe.known_types import data_type, type_or_bytes
from rtkit.recording.entries import RecordedStream, RecordedValue
from rtkit.recording.mcap_file import RecordingWriter
from rtkit.rtc.enums import PortType
from rtkit.rtc.profiles import DEFINITION, PortProfile


def test_a_type_that_nobody_defined_is_told_and_taken_as_bytes() -> None:
    said: list[str] = []
    assert type_or_bytes("IDL:RTC/TimedLong:1.0", "Own0:n", said.append) is TimedLong
    assert not said
    assert type_or_bytes("IDL:No/Such:1.0", "Own0:out", said.append) is bytes
    assert said == [
        "warning: Type not found: IDL:No/Such:1.0 of Own0:out"
        " (-m imports the module that defines it); its values stay bytes"
    ]
    with pytest.raises(NotFound):
        data_type("IDL:No/Such:1.0", "Own0:out")


def test_a_stream_of_unknown_type_stops_no_export(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run: Callable[[str], Any]
) -> None:
    monkeypatch.chdir(tmp_path)
    with open("a.mcap", "wb") as file, RecordingWriter(file) as writer:
        writer.add_channel(RecordedStream("a", "IDL:No/Such:1.0"), bytes)
        writer.add_channel(RecordedStream("b", "IDL:RTC/TimedLong:1.0"), TimedLong)
        writer.write(RecordedValue("a", 1, 1, b"\0\1\0\0\5"))
        writer.write(RecordedValue("b", 2, 2, codec_for(TimedLong).encode(TimedLong(data=7))))
    status, out, err = run("rtlog --export text -f a.mcap")
    assert status == 0
    assert err.startswith("rtlog: warning: Type not found: No::Such of stream a")
    assert [line.partition("\t")[2][:5] for line in out.splitlines()] == ["('a',", "('b',"]


def test_values_that_are_none_of_their_type_stop_no_export(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run: Callable[[str], Any]
) -> None:
    monkeypatch.chdir(tmp_path)
    good = codec_for(TimedLong).encode(TimedLong(data=7))
    with open("a.mcap", "wb") as file, RecordingWriter(file) as writer:
        writer.add_channel(RecordedStream("a", "IDL:RTC/TimedLong:1.0"), TimedLong)
        for number, payload in enumerate((b"\0\1\0\0\5", b"\0\1", good)):
            writer.write(RecordedValue("a", number, number, payload))
    status, out, err = run("rtlog --export json -f a.mcap")
    assert status == 0
    assert err.count("rtlog: warning: a value of stream a is no RTC::TimedLong: ") == 1
    values = [json.loads(line)["value"] for line in out.splitlines()]
    assert values == [[0, 1, 0, 0, 5], [0, 1], {"tm": {"sec": 0, "nsec": 0}, "data": 7}]


def test_a_port_that_carries_any_data_is_read_as_bytes() -> None:
    assert data_type("any", "A:out") is bytes
    assert data_type("IDL:any:1.0", "A:out") is bytes


FAR = "module Far { struct Off { long x; }; };"


def far(definition: str, direction: PortType = PortType.OUT) -> PortProfile:
    """Return a port of the type `Far::Off`."""
    properties = {"dataport.data_type": "IDL:Far/Off:1.0"}
    properties |= {DEFINITION: definition} if definition else {}
    return PortProfile("far", direction, properties)


def test_a_port_that_has_no_definition_takes_that_of_another_one(world: FakeManager) -> None:
    app = App("rtlog", fake_tree(world))
    world.update("Std0", ports=(far(""),))
    specs = specified(app, ["/localhost/Std0.rtc:far"])
    (alone,) = streams_of(app.tree, specs, PortType.OUT)
    world.update("Err0", ports=(far(FAR),))
    (stream,) = streams_of(app.tree, specs, PortType.OUT)
    assert (alone.definition, stream.definition) == ("", FAR)
    assert [*types_of([stream])[stream.name]().__slots__] == ["x"]


def test_what_is_defined_otherwise_is_not_played(world: FakeManager) -> None:
    app = App("rtlog", fake_tree(world))
    world.update("Std0", ports=(far(FAR, PortType.IN),))
    streams = streams_of(app.tree, specified(app, ["/localhost/Std0.rtc:far"]), PortType.IN)
    channel = RecordedStream("a", "Far::Off", (), FAR.replace("long", "double"))
    with pytest.raises(Refused, match=r"Far/Off:1\.0 is defined otherwise than in the recording"):
        _matched(app, [streams[0]._replace(name="a")], [channel])
    same = channel._replace(definition=f"// As it is.\n{FAR}")
    assert _matched(app, [streams[0]._replace(name="a")], [same]) == {"a": "a"}
