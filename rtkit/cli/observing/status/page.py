"""Lays the record of ``rtstatus`` out as one page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from datetime import UTC, datetime
from typing import Any

from rtkit.cli.shared import terminal

_FRAMES = 12
_DIRECTIONS = {"DataInPort": "<-", "DataOutPort": "->", "CorbaPort": "--"}


def page(record: Mapping[str, Any], now: datetime) -> Iterator[str]:
    """Yield the lines of the page."""
    head = " - ".join(filter(None, [record["path"], record["description"]]))
    yield terminal.styled(terminal.printable(head), terminal.STYLES["name"])
    rows = [(key, value) for key, value in _rows(record, now) if value]
    first, *others = terminal.pairs(rows)
    shown = terminal.printable(record["state"])
    yield first.replace(shown, terminal.state(record["state"]), 1)
    yield from others
    yield from _section("Ports", _ports(record["connections"]))
    yield from _section("Components", _components(record["components"]))
    hosts = [(each["name"], each["why"] or "linked") for each in record["hosts"]]
    yield from _section("Hosts", terminal.table(hosts) if hosts else [])
    yield from _section("Movable", _movable(record["movable"]))
    yield from _section("Warnings", record["warnings"])
    yield from _section("Events", map(_event, record["events"]))
    yield from _section("Log", _log(record["log"]))
    yield from _crash(record["crash"], record["log"])
    yield from _section("Output past the log", record["output"])


def _section(title: str, lines: Any) -> Iterator[str]:
    shown = [f"  {terminal.printable(line)}" for line in lines]
    if shown:
        yield from (f"{title}:", *shown)


def _rows(record: Mapping[str, Any], now: datetime) -> Iterator[tuple[str, str]]:
    manager, process = record["manager"], record["process"]
    why = f": {record['why']}" if record["why"] else ""
    yield "State", record["state"] + _since(record["since"], now) + why
    yield "Type", record["type"]
    yield "Set", record["active_set"]
    if record["kind"] == "component":
        pid = f" (pid {process['pid']})" if process["pid"] else ""
        yield "Process", f"{process['name']}{pid} {process['state']}".rstrip()
    own = f"pid {manager['pid']}" if manager["is_running"] else "not running"
    yield "Manager", f"{manager['name']} ({own})"
    for context in record["contexts"]:
        yield f"Context {context['id']}", _context(context)
    if record["memory_bytes"] is not None:
        cpu = record["cpu_percent"]
        used = f"{record['memory_bytes'] / 2**20:.1f} MiB"
        yield "Used", used + (f", {cpu:.1f} % of a processor" if cpu is not None else "")
    yield "Limits", record["limits"]
    yield "Health", "; ".join(record["health"])
    if record["restarts"] is not None:
        yield "Restarts", _restarts(record["restarts"])


def _context(context: Mapping[str, Any]) -> str:
    parts = [context["state"]] if context["is_running"] else [f"{context['state']}, stopped"]
    asked, reached = context["rate_hz"], context["reached_hz"]
    if asked:
        parts.append(f"{reached:.4g} of {asked:.4g} Hz" if reached is not None else f"{asked:g} Hz")
    elif reached is not None:
        parts.append(f"{reached:.4g} Hz")
    if context["mean_s"] is not None:
        mean, longest = context["mean_s"] * 1e3, context["longest_s"] * 1e3
        parts.append(f"a cycle {mean:.3g} ms, the longest {longest:.3g} ms")
    if context["latest_s"] and asked:
        parts.append(f"begun at most {context['latest_s'] * 1e3:.3g} ms late")
    if context["missed"] or context["missed_hz"]:
        now = context["missed_hz"]
        rate = f" ({now:.4g}/s)" if now is not None else ""
        parts.append(f"{context['missed']} periods missed{rate}")
    return ", ".join(parts)


def _restarts(restarts: Mapping[str, Any]) -> str:
    parts = [f"{restarts['count']}, policy {restarts['policy']}"]
    parts += [f"the last for {restarts['why']}"] if restarts["why"] else []
    parts += [f"comes back after {restarts['returning']}"] if restarts["returning"] else []
    return "; ".join(parts + ([restarts["given_up"]] if restarts["given_up"] else []))


def _ports(connections: Sequence[Mapping[str, Any]]) -> list[str]:
    rows = []
    for each in connections:
        rate = f"{each['rate_hz']:.4g}/s" if each["rate_hz"] is not None else ""
        for number, other in enumerate(each["to"] or ["not connected"]):
            port = each["port"] if not number else ""
            rows.append((port, _DIRECTIONS[each["type"]], other, rate if not number else ""))
    return terminal.table(rows) if rows else []


def _components(components: Sequence[Mapping[str, Any]]) -> list[str]:
    rows = [(each["name"], each["state"], each["process"], each["why"]) for each in components]
    return terminal.table(rows) if rows else []


def _movable(components: Sequence[Mapping[str, Any]]) -> list[str]:
    rows = [
        (each["name"], f"in {each['home']}", f"moved by {each['owner']} only", each["why"])
        for each in components
    ]
    return terminal.table(rows) if rows else []


def _event(event: Mapping[str, Any]) -> str:
    words = (_clock(event["time"]), event["event"], event["subject"], event["detail"])
    return "  ".join(filter(None, words))


def _log(entries: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    for each in entries:
        first, *others = each["message"].split("\n")
        yield f"{_clock(each['time'])} {each['level']:<5} <{each['source']}> {first}"
        yield from (f"    {line}" for line in (*others, *each["exception"].splitlines()))


def _crash(crash: Mapping[str, Any] | None, log: Sequence[Any]) -> Iterator[str]:
    if crash is None:
        return
    yield f"Crash: {_moment(crash['time'])}, pid {crash['pid']}"
    before = [each for each in crash["before"] if each not in log]
    for line in (crash["what"], *_culprit(crash["stack"]), *_log(before)):
        yield f"  {terminal.printable(line)}"


def _culprit(stack: str) -> list[str]:
    """Return the frames of the thread that crashed, the innermost first."""
    own = stack.partition("Current thread ")[2].partition("\n\n")[0] or stack
    return own.splitlines()[1 : _FRAMES + 1]


def _read(time: str) -> datetime:
    return datetime.fromisoformat(f"{time[:26]}+00:00")


def _moment(time: str) -> str:
    return f"{_read(time).astimezone():%Y-%m-%d %H:%M:%S}"


def _clock(time: str) -> str:
    return f"{_read(time).astimezone():%H:%M:%S.%f}"[:-3]


def _since(time: str, now: datetime) -> str:
    """Return since when that is, and for how long in its two largest units: ``2 min 5 s``."""
    if not time:
        return ""
    left = max(0, int((now.astimezone(UTC) - _read(time)).total_seconds()))
    parts: list[str] = []
    for size, unit in ((86_400, "d"), (3_600, "h"), (60, "min"), (1, "s")):
        count, left = divmod(left, size)
        if count or (unit == "s" and not parts):
            parts.append(f"{count} {unit}")
    return f" since {_moment(time)} ({' '.join(parts[:2])})"
