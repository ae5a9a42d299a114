"""Recordings read by tools of others: their reader, and their decoder by the schema in the file."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader
from mcap_ros2._dynamic import generate_dynamic

from rtkit.component import Time, TimedDoubleSeq, TimedLong, TimedString
from rtkit.component.geometry import Point2D, Pose2D, TimedPose2D
from rtkit.component.images import TimedCameraImage
from rtkit.component.sensors import CameraImage
from rtkit.component.values.codec import codec_for
from rtkit.component.values.definition import has_octets
from rtkit.recording.entries import RecordedStream, RecordedValue
from rtkit.recording.mcap_file import RecordingWriter

POSE = TimedPose2D(Time(3, 4), Pose2D(Point2D(1.5, 2.5), 3.5))
IMAGE = CameraImage(Time(1, 1), 2, 3, 24, "rgb", 0.5, b"\1\2\3")
VALUES = {
    "TimedLong(tm=Time(sec=1, nsec=2), data=-3)": TimedLong(Time(1, 2), -3),
    "TimedDoubleSeq(tm=Time(sec=5, nsec=6), data=[1.0, 2.0])": TimedDoubleSeq(
        Time(5, 6), (1.0, 2.0)
    ),
    "TimedString(tm=Time(sec=7, nsec=8), data=häl)": TimedString(Time(7, 8), "häl"),
    "TimedPose2D(tm=Time(sec=3, nsec=4), data="
    "Pose2D(position=Point2D(x=1.5, y=2.5), heading=3.5))": POSE,
    "CameraImage(tm=Time(sec=1, nsec=1), width=2, height=3, bpp=24, format=rgb, fdiv=0.5,"
    " pixels=b'\\x01\\x02\\x03')": IMAGE,
}
WORDS = {
    "octet": "uint8",
    "short": "int16",
    "unsigned short": "uint16",
    "long": "int32",
    "unsigned long": "uint32",
    "double": "float64",
    "string": "string",
}


def ros_name(name: str) -> str:
    module, _, rest = name.rpartition("::")
    return f"{module.lower()}/{rest}"


def ros_definitions(idl: str) -> dict[str, str]:
    """Return the structs of a schema in the language that the decoder reads."""
    made = {}
    idl = re.sub(r"//.*", "", idl)
    for module, name, body in re.findall(r"module (\w+) \{\s*struct (\w+) \{(.*?)\};", idl, re.S):
        lines = []
        for kind, field in re.findall(r"([\w :<>]+?) (\w+);", body):
            many = re.fullmatch(r"sequence<(.*)>", kind.strip())
            item = many[1] if many else kind.strip()
            lines.append(f"{WORDS.get(item) or ros_name(item)}{'[]' * bool(many)} {field.lower()}")
        made[ros_name(f"{module}::{name}")] = "\n".join(lines)
    return made


def decoded(name: str, idl: str, payload: bytes) -> Any:
    definitions = ros_definitions(idl)
    text = definitions.pop(ros_name(name))
    rule = "=" * 80
    text += "".join(f"\n{rule}\nMSG: {other}\n{body}" for other, body in definitions.items())
    return generate_dynamic(ros_name(name), text)[ros_name(name)](payload)


@pytest.mark.parametrize("told", VALUES)
def test_what_is_recorded_is_understood_by_what_the_file_says(told: str, tmp_path: Path) -> None:
    value = VALUES[told]
    payload = codec_for(type(value)).encode(value)
    path = tmp_path / "x.mcap"
    with path.open("wb") as file, RecordingWriter(file) as writer:
        writer.add_channel(RecordedStream("a", "", ("/localhost/A.rtc:out",)), type(value))
        for number in range(3):
            writer.write(RecordedValue("a", 10**18, 10**18 + number, payload))
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        found = list(reader.iter_messages())
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.message_count == len(found) == 3
    schema, channel, message = found[0]
    assert schema is not None
    assert (channel.message_encoding, schema.encoding) == ("cdr", "omgidl")
    assert str(decoded(schema.name, schema.data.decode(), message.data)) == told


def test_what_has_octets() -> None:
    assert has_octets(CameraImage)
    assert has_octets(TimedCameraImage)
    assert has_octets(bytes)
    assert not has_octets(TimedPose2D)
    assert not has_octets(TimedDoubleSeq)
