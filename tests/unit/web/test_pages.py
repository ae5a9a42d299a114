"""Streams to pages: order, latest rates, and a new beginning for who reads too slowly."""

from __future__ import annotations

import asyncio
import json
from typing import Any

import pytest

from rtkit.errors import NotFound
from rtkit.web.pages import CHANGE, NOTICE, RATES, Pages, PageStream


def read(event: bytes) -> list[tuple[str, Any]]:
    blocks = filter(None, event.decode().split("\n\n"))
    pairs = (block.split("\n") for block in blocks)
    return [(kind.removeprefix("event: "), json.loads(data[6:])) for kind, data in pairs]


def test_changes_come_in_order_and_rates_are_the_latest() -> None:
    async def main() -> None:
        pages = Pages(1)
        stream = pages.stream(lambda: {"revision": 0})
        assert read(await anext(stream)) == [("picture", {"revision": 0})]
        assert pages.is_full
        for number in range(3):
            pages.send(RATES, {"rate": number})
            pages.send(CHANGE, {"revision": number})
        assert read(await anext(stream)) == [
            *(("change", {"revision": number}) for number in range(3)),
            ("rates", {"rate": 2}),
        ]
        await stream.aclose()
        assert not pages.is_full

    asyncio.run(main())


def test_a_page_is_shown_nothing_before_the_system_is_known() -> None:
    async def main() -> None:
        known: list[dict[str, int]] = []
        pages = Pages(1)
        stream = pages.stream(lambda: known[0] if known else None)
        first = asyncio.ensure_future(anext(stream))
        await asyncio.sleep(0)
        pages.send(NOTICE, {"text": "no manager"})
        assert read(await first) == [("notice", {"text": "no manager"})]
        second = asyncio.ensure_future(anext(stream))
        await asyncio.sleep(0)
        pages.wake()
        await asyncio.sleep(0)
        assert not second.done()
        known.append({"revision": 0})
        pages.wake()
        assert read(await second) == [("picture", {"revision": 0})]
        await stream.aclose()

    asyncio.run(main())


def test_a_slow_page_begins_anew() -> None:
    async def main() -> None:
        pages = Pages(1)
        stream = pages.stream(lambda: {"revision": 1000})
        await anext(stream)
        for number in range(1000):
            pages.send(CHANGE, {"revision": number})
        assert read(await anext(stream))[0] == ("picture", {"revision": 1000})
        await stream.aclose()

    asyncio.run(main())


def test_a_page_gets_the_latest_values_of_the_ports_that_it_shows() -> None:
    async def main() -> None:
        pages = Pages(2)
        streams = {id: pages.stream(dict, id) for id in ("one", "two")}
        for stream in streams.values():
            await anext(stream)
        pages.watch("one", frozenset({"a", "b"}))
        pages.watch("two", frozenset({"c"}))
        assert pages.watched() == {"a", "b", "c"}
        pages.send_values({"a": {"count": 1}, "d": {"count": 1}})
        pages.send_values({"a": {"count": 2}, "c": {"count": 3}})
        sent = {id: read(await anext(stream)) for id, stream in streams.items()}
        assert sent == {
            "one": [("values", {"values": {"a": {"count": 2}}})],
            "two": [("values", {"values": {"c": {"count": 3}}})],
        }
        await streams["two"].aclose()
        assert pages.watched() == {"a", "b"}
        with pytest.raises(NotFound):
            pages.watch("two", frozenset())
        await streams["one"].aclose()

    asyncio.run(main())


def test_properties_go_to_one_page_and_of_each_name_the_latest() -> None:
    async def main() -> None:
        pages = Pages(2)
        ended: list[PageStream] = []
        pages.when_ended(ended.append)
        streams = {id: pages.stream(dict, id) for id in ("one", "two")}
        for stream in streams.values():
            await anext(stream)
        one = pages.found("one")
        for number in range(3):
            one.put_properties({"a": number, f"b{number}": number})
        pages.send(CHANGE, {})
        shown = [("change", {}), ("properties", {"a": 2, "b0": 0, "b1": 1, "b2": 2})]
        assert read(await anext(streams["one"])) == shown
        assert read(await anext(streams["two"])) == [("change", {})]
        await streams["one"].aclose()
        assert ended == [one]
        with pytest.raises(NotFound):
            pages.found("one")
        await streams["two"].aclose()

    asyncio.run(main())
