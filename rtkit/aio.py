"""The tree of scripts for asyncio: the methods of `rtkit.Tree`, awaited.

Each call runs on a thread of its own, so the event loop goes on. A task that is cancelled stops
what it waits for; a plan under way ends in order first, as after Ctrl-C. Types are in ``aio.pyi``,
made from those of `rtkit.Tree`.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncGenerator, Callable, Generator
from contextvars import copy_context
from functools import partial, wraps
from threading import Thread
from typing import Any, Generic, TypeVar

from rtkit.api.connect import connect as connect_now
from rtkit.api.plan import SystemPlan
from rtkit.api.properties import Properties
from rtkit.api.tree import Tree
from rtkit.link import stopping
from rtkit.tree.client import DEFAULT_TIMEOUT_S

T = TypeVar("T")
_GRACE_S = 0.5
"""How long a cancelled call is waited for, unless it ends in order; it is bounded by itself [s]."""
_IN_ORDER = {"apply", "apply_profile", "bring_up", "goto", "start", "stop", "teardown"}
_END = object()
ATTRIBUTES = ("host", "manager", "notify", "timeout_s")
"""Attributes of a tree that need no waiting."""


async def in_thread(call: Callable[[], T], *, is_orderly: bool = False) -> T:
    """Return the result of a call on a thread of its own; a cancellation stops its waiting.

    One that is orderly is waited for then, as it goes back, or tells what is left.
    """
    loop = asyncio.get_running_loop()
    outcome: asyncio.Future[T] = loop.create_future()
    request = stopping.StopRequest()

    def finish(result: Any, error: BaseException | None) -> None:
        request.close()
        if error is None:
            outcome.set_result(result)
        else:
            outcome.set_exception(error)

    def work() -> None:
        stopping.heed(request)
        result, failure = None, None
        try:
            result = call()
        except BaseException as error:
            failure = error
        if not loop.is_closed():  # else nobody waits any more
            loop.call_soon_threadsafe(finish, result, failure)

    Thread(target=copy_context().run, args=(work,), daemon=True).start()
    try:
        return await asyncio.shield(outcome)
    except asyncio.CancelledError as cancelled:
        request.ring()
        await asyncio.wait([outcome], timeout=None if is_orderly else _GRACE_S)
        if outcome.done() and (why := outcome.exception()) is not None and str(why):
            cancelled.add_note(str(why))
        raise


class AsyncStream(Generic[T]):
    """Values as they come: ``async for value in tree.values(port)``.

    It begins with the loop, or with ``async with tree.events() as events``: what comes from then on
    is not missed.
    """

    def __init__(self, make: Callable[[], Generator[T, None, None]]) -> None:
        """Begin later with what `make` returns."""
        self._values = _stream(make)
        self._is_begun = False

    def __aiter__(self) -> AsyncStream[T]:
        return self

    async def __anext__(self) -> T:
        await self._begin()
        value: T = await anext(self._values)
        return value

    async def __aenter__(self) -> AsyncStream[T]:
        await self._begin()
        return self

    async def __aexit__(self, *raised: object) -> None:
        await self.aclose()

    async def aclose(self) -> None:
        """End it."""
        await self._values.aclose()

    async def _begin(self) -> None:
        if not self._is_begun:
            self._is_begun = True
            await anext(self._values)


async def _stream(make: Callable[[], Generator[T, None, None]]) -> AsyncGenerator[Any, None]:
    values = await in_thread(make)
    try:
        yield None
        while (value := await in_thread(partial(next, values, _END))) is not _END:
            yield value
    finally:
        if not values.gi_running:  # else a thread that was left alone closes it
            await in_thread(values.close)


class _Awaited:
    """An object whose methods wait, as one whose methods are awaited."""

    def __init__(self, sync: Any) -> None:
        self._sync = sync

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {self._sync!r}>"

    def __str__(self) -> str:
        return str(self._sync)

    def __bool__(self) -> bool:
        return bool(self._sync)


def _method(method: Any) -> Any:
    """Return a method that awaits a method that waits."""
    if str(method.__annotations__["return"]).startswith("Stream["):

        @wraps(method)
        def stream(self: _Awaited, *args: Any, **options: Any) -> AsyncStream[Any]:
            return AsyncStream(partial(method, self._sync, *args, **options))

        return stream

    @wraps(method)
    async def awaited(self: _Awaited, *args: Any, **options: Any) -> Any:
        call = partial(method, self._sync, *args, **options)
        result = await in_thread(call, is_orderly=method.__name__ in _IN_ORDER)
        return AsyncPlan(result) if isinstance(result, SystemPlan) else result

    return awaited


def _attribute(name: str) -> Any:
    return property(lambda self: getattr(self._sync, name))


class AsyncProperties(_Awaited):
    """Live properties, awaited: see `rtkit.api.properties.Properties`."""


class AsyncPlan(_Awaited):
    """A plan whose `apply` is awaited: see `rtkit.SystemPlan`."""

    def __len__(self) -> int:
        return len(self._sync)


class AsyncTree(_Awaited):
    """A connection to one manager, for asyncio: the methods of `rtkit.Tree`, awaited.

    Example::

        async with rtkit.aio.connect() as tree:
            await tree.apply_profile("robot.xml", rollback=True)
            async with asyncio.timeout(5.0):
                async for each in tree.values("/localhost/Camera0.rtc:image"):
                    print(each.value)
    """

    def __dir__(self) -> list[str]:
        return [*waits(Tree), *ATTRIBUTES, "properties"]

    @property
    def properties(self) -> AsyncProperties:
        """Live properties of components, managers, this host and served objects."""
        return AsyncProperties(self._sync.properties)

    async def __aenter__(self) -> AsyncTree:
        return self

    async def __aexit__(self, *raised: object) -> None:
        await in_thread(self._sync.close)


def waits(cls: type) -> list[str]:
    """Return the public methods of a class that wait."""
    names = Tree.__dir__(None) if cls is Tree else dir(cls)  # type: ignore[arg-type]
    public = (each for each in names if each[0] != "_" and each != "live")  # events tell the same
    return [each for each in public if callable(getattr(cls, each, None))]


for _target, _source, _names in (
    (AsyncTree, Tree, waits(Tree)),
    (AsyncProperties, Properties, waits(Properties)),
    (AsyncPlan, SystemPlan, ["apply"]),
):
    for _name in _names:
        setattr(_target, _name, _method(getattr(_source, _name)))
for _name in ATTRIBUTES:
    setattr(AsyncTree, _name, _attribute(_name))
for _name in ("profile", "cost", "steps", "as_dict", "dot"):
    setattr(AsyncPlan, _name, _attribute(_name))


class Connecting:
    """A connection that is awaited, or entered by ``async with``."""

    def __init__(self, make: Callable[[], Tree]) -> None:
        """Connect later, by what `make` does."""
        self._make = make
        self._tree: AsyncTree | None = None

    def __await__(self) -> Generator[Any, None, AsyncTree]:
        return self._connect().__await__()

    async def __aenter__(self) -> AsyncTree:
        self._tree = await self._connect()
        return self._tree

    async def __aexit__(self, *raised: object) -> None:
        if self._tree is not None:
            await self._tree.__aexit__()

    async def _connect(self) -> AsyncTree:
        return AsyncTree(await in_thread(self._make))


def connect(
    manager: str = "",
    timeout_s: float = DEFAULT_TIMEOUT_S,
    *,
    start: bool = False,
    notify: Callable[[str], object] | None = None,
) -> Connecting:
    """Connect to a manager: ``async with rtkit.aio.connect() as tree:``, or await it.

    The arguments and errors are those of `rtkit.connect`; `notify` is called by the event loop.
    """
    options: dict[str, Any] = {"start": start}
    if notify is not None:
        loop = asyncio.get_running_loop()
        options["notify"] = lambda text: loop.call_soon_threadsafe(notify, text)
    return Connecting(partial(connect_now, manager, timeout_s, **options))
