"""Statistics of streams."""

from __future__ import annotations

import pytest

from rtkit.component import Time, TimedLong
from rtkit.component.geometry import Point2D
from rtkit.component.sensors import CameraImage
from rtkit.component.values.codec import codec_for
from rtkit.probe.port_spec import Stream
from rtkit.probe.stats import Stats, stamp_reader
from rtkit.probe.stream_report import lines_of, record_of, size_text
from rtkit.probe.tap import Arrival

SECOND = 1_000_000_000


def arrivals(*times_ms: int, age_ms: int = 2) -> Stats:
    stats = Stats(stamp_reader(TimedLong))
    encode = codec_for(TimedLong).encode
    for time_ms in times_ms:
        arrived = 1000 * SECOND + time_ms * 1_000_000
        stamp = Time(*divmod(arrived - age_ms * 1_000_000, SECOND))
        stats.take(Arrival("s", arrived, encode(TimedLong(stamp, 1))))
    return stats


def test_steady_values():
    told = arrivals(0, 10, 20, 30).summary()
    assert told.values == 4
    assert told.rate_hz == pytest.approx(100.0)
    assert told.interval_s is not None
    assert told.interval_s.mean == pytest.approx(0.01)
    assert told.interval_s.deviation == pytest.approx(0.0, abs=1e-9)
    assert told.size_bytes is not None
    assert told.bytes_per_s == pytest.approx(100 * told.size_bytes.mean)


def test_jitter_and_extremes():
    told = arrivals(0, 10, 30, 40).summary()
    assert told.interval_s is not None
    assert (told.interval_s.least, told.interval_s.most) == pytest.approx((0.01, 0.02))
    assert told.interval_s.deviation == pytest.approx(0.004714, rel=1e-3)


def test_the_age_is_told_by_the_stamp():
    told = arrivals(0, 10, age_ms=7).summary()
    assert told.latency_s is not None
    assert told.latency_s.median == pytest.approx(0.007)


@pytest.mark.parametrize("count", [0, 1])
def test_too_few_values_for_a_rate(count):
    told = arrivals(*range(count)).summary()
    assert (told.values, told.rate_hz, told.interval_s) == (count, 0.0, None)
    assert list(lines_of(Stream("s", ()), told))[1].split() == ["values", str(count)]


@pytest.mark.parametrize("cls", [bytes, Point2D])
def test_values_without_a_stamp(cls):
    assert stamp_reader(cls)(bytes(64)) is None


def test_a_stamp_is_read_in_both_byte_orders_and_never_beyond_the_end():
    read = stamp_reader(CameraImage)
    little = b"\x00\x01\x00\x00" + (5).to_bytes(4, "little") + (6).to_bytes(4, "little")
    big = b"\x00\x00\x00\x00" + (5).to_bytes(4, "big") + (6).to_bytes(4, "big")
    assert read(little) == read(big) == 5 * SECOND + 6
    assert read(little[:-1]) is None
    assert read(b"") is None


def test_numbers_in_fields():
    stats = Stats(lambda _: None, {"size": len, "odd": lambda _: float("inf")})
    for size in (1, 3):
        stats.take(Arrival("s", size, bytes(size)))
    told = stats.summary()
    spread = told.fields["size"]
    assert spread is not None
    assert (spread.mean, spread.least, spread.most) == (2, 1, 3)
    assert told.fields["odd"] is None
    assert any(line.startswith("  size      mean 2,") for line in lines_of(Stream("s", ()), told))


def test_the_record_has_the_spread():
    record = record_of(Stream("s", ()), arrivals(0, 10).summary(), 0)
    assert record["interval_s"]["mean"] == pytest.approx(0.01)


@pytest.mark.parametrize(
    ("size", "text"),
    [
        (0, "0 B"),
        (999, "999 B"),
        (999.6, "1 kB"),
        (1500, "1.5 kB"),
        (2e8, "200 MB"),
        (5e15, "5e+03 TB"),
    ],
)
def test_sizes(size, text):
    assert size_text(size) == text
