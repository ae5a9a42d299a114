"""Mutable twins of data types, and their conversion."""

from __future__ import annotations

from typing import Any

import pytest

from rtkit.component.standard import names_of
from rtkit.component.values.codec import codec_for
from rtkit.component.values.type_layout import layout_of, zero
from rtkit.component.values.typenames import type_by_name
from rtkit.openrtm.corba.standard_types import rtc_value
from rtkit.openrtm.corba.twins import default_of, freezer_of, thawer_of, twin_of


def frozen(name: str) -> Any:
    return type_by_name(f"RTC::{name}")


STRUCTURES = [name for name in names_of("RTC") if hasattr(frozen(name), "__dataclass_fields__")]


@pytest.mark.parametrize("name", STRUCTURES)
def test_the_default_of_each_standard_type_is_the_zero_value(name: str) -> None:
    cls = frozen(name)
    value = default_of(rtc_value(name))
    assert freezer_of(cls)(value) == zero(layout_of(cls))
    back = thawer_of(cls)(zero(layout_of(cls)))
    assert back == value
    assert back is not value
    assert type(value)(*(getattr(value, each) for each in value.field_names)) == value


def test_a_value_is_made_by_position_and_changed_in_place() -> None:
    data = rtc_value("TimedLongSeq")(rtc_value("Time")(1, 2), [3])
    snapshot = freezer_of(frozen("TimedLongSeq"))(data)
    data.data.append(4)
    data.tm.sec = 9
    assert (snapshot.tm.sec, snapshot.data) == (1, (3,))
    assert repr(data) == "RTC.TimedLongSeq(tm=RTC.Time(sec=9, nsec=2), data=[3, 4])"


@pytest.mark.parametrize(
    ("name", "given", "read"),
    [
        ("TimedOctetSeq", [1, 2], b"\x01\x02"),
        ("TimedOctetSeq", bytearray(b"ab"), b"ab"),
        ("TimedOctetSeq", "a\xff", b"a\xff"),
        ("TimedCharSeq", "ab", "ab"),
        ("TimedCharSeq", ["a", "b"], "ab"),
        ("TimedDoubleSeq", (1, 2.5), [1.0, 2.5]),
        ("TimedBooleanSeq", [1, 0], [True, False]),
        ("TimedWString", "日本", "日本"),
        ("TimedDouble", 3, 3.0),
    ],
)
def test_what_authors_write_arrives_as_omniorb_gives_it(name: str, given: Any, read: Any) -> None:
    cls = frozen(name)
    data = rtc_value(name)(rtc_value("Time")(0, 0), given)
    codec = codec_for(cls)
    arrived = thawer_of(cls)(codec.decode(codec.encode(freezer_of(cls)(data)))).data
    assert (arrived, type(arrived)) == (read, type(read))


def test_fields_may_be_nothing_until_they_are_written() -> None:
    descriptor = rtc_value("_d_TimedPose3D")
    data = rtc_value("TimedPose3D")(*[None] * ((len(descriptor) - 4) // 2))
    with pytest.raises(AttributeError):
        freezer_of(frozen("TimedPose3D"))(data)
    data.tm = rtc_value("Time")(0, 0)
    data.data = default_of(rtc_value("Pose3D"))
    assert freezer_of(frozen("TimedPose3D"))(data) == zero(layout_of(frozen("TimedPose3D")))


def test_items_of_enumerations_stand_beside_them() -> None:
    ok, error = rtc_value("RTC_OK"), rtc_value("RTC_ERROR")
    assert (str(ok), ok._v, str(error), error._v) == ("RTC_OK", 0, "RTC_ERROR", 1)
    assert ok == rtc_value("ReturnCode_t")._item(0) != error
    assert twin_of(frozen("Pose2D")) is rtc_value("Pose2D")
