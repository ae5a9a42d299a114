"""Object whose code misbehaves in every way, and the promises its endpoints must keep."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import AsyncIterator, Iterator

from conformance import Door

from rtkit.property.messages import Answer


class Mumbling(BaseException):
    """Raised, and has no text either."""

    def __str__(self) -> str:
        raise SystemExit("nothing to say")


class Unruly:
    """Raises what ends processes, blocks, counts, awaits.

    Attributes:
        is_free: Until it is set the getter of ``stuck`` does not return.
    """

    def __init__(self) -> None:
        self.plain = 1.0
        self._called: list[str] = []
        self._warmth = 21.5
        self._is_free = threading.Event()

    def free(self) -> None:
        """Let the getter of ``stuck`` return."""
        self._is_free.set()

    @property
    def exits(self) -> float:
        self._called.append("exits")
        raise SystemExit(1)

    @exits.setter
    def exits(self, value: float) -> None:
        raise SystemExit(value)

    @property
    def breaks(self) -> float:
        self._called.append("breaks")
        raise GeneratorExit

    @property
    def interrupts(self) -> float:
        self._called.append("interrupts")
        raise KeyboardInterrupt

    @property
    def mumbles(self) -> float:
        self._called.append("mumbles")
        raise Mumbling

    @property
    def lacks(self) -> float:
        self._called.append("lacks")
        return self.nothing_of_this_name  # type: ignore[attr-defined,no-any-return]

    @property
    def stuck(self) -> int:
        self._called.append("stuck")
        self._is_free.wait()
        return 7

    def get_next(self) -> int:
        self._called.append("next")
        return len(self._called)

    async def get_warmth(self) -> float:
        self._called.append("warmth")
        await asyncio.sleep(0)
        return self._warmth

    async def set_warmth(self, value: float) -> None:
        await asyncio.sleep(0)
        if value < 0:
            raise SystemExit("too cold")
        self._warmth = value

    def leave(self) -> None:
        raise SystemExit(3)

    async def warm_up(self) -> float:
        await asyncio.sleep(0)
        return self._warmth

    async def warm_for_ever(self) -> None:
        await asyncio.Event().wait()

    def steps(self) -> Iterator[int]:
        yield 1
        yield 2

    async def awaited_steps(self) -> AsyncIterator[int]:
        yield 1
        yield 2


def check_only_its_own_request_suffers(endpoint: Door, thing: Unruly) -> None:
    """Ask for everything; whatever the code of the object does, all else is answered."""
    names = str(endpoint.ask("properties").value())
    assert "stuck" in names
    assert "next" in names
    assert endpoint.ask("properties?all&meta").error == ""
    assert thing._called == []  # names are told without a look at values
    for name in ("exits", "breaks", "interrupts", "mumbles", "lacks"):
        for _ in range(2):
            assert endpoint.ask(name).error == "internal", name
        assert thing._called[-1] == name
    assert endpoint.ask("exits", "1").error == "internal"
    assert endpoint.ask("stuck?timeout=0.02").error == "timeout"
    assert endpoint.ask("plain") == Answer("1.0")
    assert endpoint.ask("plain", "2") == Answer("")
    assert endpoint.ask("stuck?timeout=0.02").error == "timeout"
    assert endpoint.ask("warmth") == Answer("21.5")
    assert endpoint.ask("warmth", "3.5") == Answer("")
    assert endpoint.ask("warmth", "-1").error == "internal"
    assert endpoint.ask("warmth") == Answer("3.5")
    failed = '<call state="failed"><error code="internal">SystemExit: 3</error></call>'
    assert endpoint.ask("leave?echo", "") == Answer(failed)
    assert endpoint.ask("warm_up?echo", "") == Answer(
        '<call state="done"><result>3.5</result></call>'
    )
    told = Answer('<call state="done"><progress>2</progress></call>')
    assert endpoint.ask("steps?echo", "") == told
    assert endpoint.ask("awaited_steps?echo", "") == told
    with endpoint.listen("warm_for_ever") as events:
        assert "idle" in str(next(events).payload)
        assert endpoint.ask("warm_for_ever", "") == Answer("")
        while endpoint.ask("warm_for_ever.stop", "true").error:
            pass  # it is about to begin
        while 'state="stopped"' not in str(next(events).payload):
            pass
        assert endpoint.ask("warm_for_ever?echo&timeout=0.02", "").error == "timeout"
        assert endpoint.ask("warm_for_ever.stop", "true").error == ""
    with endpoint.listen("warmth") as events:
        assert next(events).payload == "3.5"
    assert thing._called.count("stuck") == 1
    thing.free()
    assert endpoint.ask("stuck") == Answer("7")
