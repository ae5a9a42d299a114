from __future__ import annotations

import pytest

from rtkit.profile.common import ExtensionProperty
from rtkit.profile.words import normal_data_type, property_value, strip_instance


@pytest.mark.parametrize(
    ("port", "instance", "own"),
    [
        ("ConsoleIn0.out", "ConsoleIn0", "out"),
        ("out", "ConsoleIn0", "out"),
        ("Tank-TankIoRTC.VLP-16", "Tank-TankIoRTC", "VLP-16"),
        ("A0.B.c", "A0", "B.c"),
        ("A0.B.c", "A0.B", "c"),
        ("A0", "A0", "A0"),
        ("A0.", "A0", "A0."),
        ("A01.out", "A0", "A01.out"),
        ("", "A0", ""),
    ],
)
def test_strip_instance(port: str, instance: str, own: str) -> None:
    assert strip_instance(port, instance) == own


@pytest.mark.parametrize(
    ("text", "normal"),
    [
        ("IDL:RTC/TimedLong:1.0", "IDL:RTC/TimedLong:1.0"),
        ("RTC::TimedLong", "IDL:RTC/TimedLong:1.0"),
        ("TimedLong", "IDL:RTC/TimedLong:1.0"),
        (" ::RTC::TimedLong ", "IDL:RTC/TimedLong:1.0"),
        ("idl:RTC/TimedLong:2.3", "IDL:RTC/TimedLong:2.3"),
        ("Img::TimedCameraImage", "IDL:Img/TimedCameraImage:1.0"),
        ("a::b::c", "IDL:a/b/c:1.0"),
        ("IDL:a/b/c:1.0", "IDL:a/b/c:1.0"),
        ("", ""),
        ("Any", "Any"),
    ],
)
def test_normal_data_type(text: str, normal: str) -> None:
    assert normal_data_type(text) == normal
    assert normal_data_type(normal) == normal


def test_property_value() -> None:
    properties = (
        ExtensionProperty("a", ""),
        ExtensionProperty("b"),
        ExtensionProperty("a", "second"),
    )
    assert property_value(properties, "a") == ""
    assert property_value(properties, "b") is None
    assert property_value(properties, "c") is None
