"""Required answers of a small device: the conformance suite without the rows of `LEFT_OUT`.

The README of ``examples/embedded`` has the same table.
"""

from __future__ import annotations

import re

from conformance import ROWS, Door, Row

LEFT_OUT: dict[str, str] = {
    "elements, values of any type": r"(GET|SET) (target|any)\b",
    "bytes, values of more than one line": r"(GET|SET) blob|SET notes |GET notes = Zeile|SET \S+ {",
    "parameters of properties": r"(GET|SET) pose\b|GET .*\.parameters",
    "actions": r"(GET|SET) (double|fail|tally)\b",
    "meta data, GUI, history": r"(GET|SET) .*\.(meta|gui|history)\b",
    "choice and values in lists of names": r"GET (.*\.)?properties\?(all|match|names|meta)",
    "several set at once": r"SET (.*\.)?properties |GET count = 9|GET arm\.joint\.1 = 7",
    "revisions": r"SET speed\?if=1 ",
    "parts of vectors by number": r"GET \w+\.5 ",
    "numbers kept as they were written": r"SET location\.x 5 |GET location = \(5 ",
    "vectors set as a whole": r"SET location \(",
    "UTF-8 in names is not looked at": r"GET (%ff%fe|sp%eed) ",
}
"""What is left out, and the rows that are about it."""


def small_rows() -> tuple[Row, ...]:
    """Return the rows that a small device answers."""
    return tuple(row for row in ROWS if not any(re.match(each, _told(row)) for each in
                                                LEFT_OUT.values()))  # fmt: skip


def _told(row: Row) -> str:
    target, payload, expected = row
    asked = f"GET {target} " if payload is None else f"SET {target} {str(payload)[:80]} "
    return f"{asked}= {expected!s}"


def check_small_events(endpoint: Door) -> None:
    """Listen in every way that a small device knows; what changes is set over the same door."""
    with endpoint.listen("count") as events:
        before = next(events).payload
        for value in ("20", "21", "-3"):
            assert endpoint.ask("count", value).error == ""
            assert next(events).payload == value
        assert before != "20"
    with endpoint.listen("count?initial=0") as events:
        assert endpoint.ask("count", "5").error == ""
        assert next(events).payload == "5"
    with endpoint.listen("mode?every=0.02") as modes, endpoint.listen("location") as locations:
        assert next(locations).payload == endpoint.ask("location").payload
        assert next(modes).payload == endpoint.ask("mode").payload
        assert endpoint.ask("location.c", "2.5").error == ""
        assert str(next(locations).payload).endswith(" 2.5)")
        assert endpoint.ask("mode?echo", "idle").payload == "idle"
    with endpoint.listen("uptime?lease=0") as events:
        heard = [float(next(events).payload) for _ in range(3)]
        assert heard == sorted(set(heard)), "it changes by itself"
    for target, code in (
        ("nope", "unknown"),
        ("count?queue=0", "bad-parameter"),
        ("count?queue=2", "bad-parameter"),
        ("count?every=-1", "bad-parameter"),
        ("count?every=inf", "bad-parameter"),
        ("count?mode=some", "bad-parameter"),
        ("count?nonsense=1", "bad-parameter"),
        ("count?remove", "unknown"),
        ("door_code", "write-only"),
        ("broken", "internal"),
    ):
        name, mark, tail = target.partition("?")
        assert endpoint.ask(f"{name}.listen{mark}{tail}", "self").error == code, target
    assert endpoint.ask("count.listen", "tcp://elsewhere/x").error == "denied"
    for name in ("speed", "mode", "name", "label"):
        assert endpoint.ask(f"{name}.listen?initial=0", "self").error == ""
    assert endpoint.ask("count.listen", "self").error == "denied", "there is room for four"
    for name in ("speed", "mode", "name", "label"):
        assert endpoint.ask(f"{name}.listen?remove", "self").error == ""
