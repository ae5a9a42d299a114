"""Reports statistics of streams as lines of text and as JSON."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rtkit.probe.port_spec import Stream
from rtkit.probe.stats import Spread, Summary

_SIZES = ("B", "kB", "MB", "GB", "TB")


def lines_of(stream: Stream, summary: Summary) -> Iterator[str]:
    """Yield the lines about one stream."""
    yield f"{stream.name}  {' '.join(str(end.path) for end in stream.ends)}"
    yield f"  values    {summary.values}"
    if summary.interval_s is not None:
        yield f"  rate      {summary.rate_hz:.4g} Hz, {size_text(summary.bytes_per_s)}/s"
        yield f"  interval  {_times(summary.interval_s)}"
    if summary.size_bytes is not None:
        least, most = size_text(summary.size_bytes.least), size_text(summary.size_bytes.most)
        yield f"  size      {least}" + (f" to {most}" if least != most else "")
    if summary.latency_s is not None:
        yield f"  latency   {_times(summary.latency_s)}"
        if stream.clock.offset_s:
            ahead = f"{stream.clock.offset_s:+.4f} s (± {stream.clock.bound_s:.4f} s)"
            yield f"  clock     of {stream.clock.host}, {ahead}, taken off"
    for name, spread in summary.fields.items():
        if spread is not None:
            yield f"  {name:<8}  {_numbers(spread)}"


def record_of(stream: Stream, summary: Summary, lost: int) -> dict[str, Any]:
    """Return the same as data for JSON; times in seconds; `lost` of all streams."""
    return {
        "stream": stream.name,
        "ports": [str(end.path) for end in stream.ends],
        "type": stream.data_type,
        "values": summary.values,
        "lost": lost,
        "rate_hz": summary.rate_hz,
        "bytes_per_s": summary.bytes_per_s,
        "interval_s": summary.interval_s._asdict() if summary.interval_s else None,
        "size_bytes": summary.size_bytes._asdict() if summary.size_bytes else None,
        "clock": stream.clock._asdict(),
        "latency_s": summary.latency_s._asdict() if summary.latency_s else None,
        "fields": {name: each._asdict() if each else None for name, each in summary.fields.items()},
    }


def size_text(size: float) -> str:
    """Return a number of bytes with three digits and a unit."""
    for unit in _SIZES[:-1]:
        if size < 999.5:
            return f"{size:.3g} {unit}"
        size /= 1000
    return f"{size:.3g} {_SIZES[-1]}"


def _times(spread: Spread) -> str:
    return ", ".join(f"{name} {_time_text(value)}" for name, value in _parts(spread, "jitter"))


def _numbers(spread: Spread) -> str:
    return ", ".join(f"{name} {value:.6g}" for name, value in _parts(spread, "deviation"))


def _parts(spread: Spread, deviation: str) -> tuple[tuple[str, float], ...]:
    return (
        ("mean", spread.mean),
        (deviation, spread.deviation),
        ("min", spread.least),
        ("median", spread.median),
        ("99 %", spread.p99),
        ("max", spread.most),
    )


def _time_text(seconds: float) -> str:
    for limit, scale, unit in ((1e-3, 1e6, "µs"), (1.0, 1e3, "ms")):
        if abs(seconds) < limit:
            return f"{seconds * scale:.3g} {unit}"
    return f"{seconds:.4g} s"
