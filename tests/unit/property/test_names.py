"""Names that come and go: what lists them is asked for each, also for what is not there yet."""

from __future__ import annotations

import threading
import time
from collections.abc import Collection, Mapping

import pytest

from rtkit.property.codes import PropertyError
from rtkit.property.names import Names, NameTable
from rtkit.property.objects import Exported
from rtkit.property.requests import ListeningRequester, PropertyRequest
from rtkit.property.service import Service


class Drawer(Names):
    """Keeps bytes by name."""

    label: str = "papers"

    def __init__(self) -> None:
        self._kept: dict[str, bytes] = {}
        self._names: tuple[str, ...] = ()
        self._reads = 0
        self._lists = 0
        self._is_still = False

    def put(self, *names: str) -> None:
        self._kept |= dict.fromkeys(names, b"x")
        self._names = tuple(self._kept)

    def take(self, *names: str) -> None:
        for name in names:
            del self._kept[name]
        self._names = tuple(self._kept)

    def names(self) -> Collection[str]:
        self._lists += 1
        return self._names

    def has_changed(self) -> bool:
        return not self._is_still

    def get(self, name: str, offset: int = 0) -> bytes:
        self._reads += 1
        if name not in self._kept:
            raise PropertyError("unknown", f"no such property: {name}")
        return self._kept[name][offset:]

    def set(self, name: str, value: bytes, delete: bool = False) -> None:
        if name.startswith("no"):
            raise PropertyError("denied", "not that")
        if delete:
            self.take(name)
        else:
            self._kept[name] = value
            self._names = tuple(self._kept)

    def stamp(self, name: str) -> object:
        return self._kept.get(name)

    def about(self, name: str) -> Mapping[str, object]:
        return {"size": len(self._kept[name])}


class Cabinet:
    def __init__(self) -> None:
        self.drawer = Drawer()
        self.levels = Levels()


class Levels(Names):
    """Numbers, which are only read, and lists of them."""

    def names(self) -> Collection[str]:
        return ("high", "all", "all.first")

    def get(self, name: str) -> float:
        return 1.5 if name != "all" else (1.0, 2.0)  # type: ignore[return-value]

    def hint(self, name: str) -> object:
        return list[float] if name == "all" else None


@pytest.fixture
def drawer() -> Drawer:
    return Drawer()


def served(thing: object) -> Service:
    service = Service()
    Exported(service, thing)
    return service


def code(service: Service, target: str, payload: str | bytes | None = None) -> str:
    with pytest.raises(PropertyError) as caught:
        service.get(target) if payload is None else service.set(target, payload)
    return caught.value.code


def test_names_stand_beside_the_members_of_the_object(drawer: Drawer) -> None:
    drawer.put("a.txt", "b")
    service = served(drawer)
    assert service.get("properties") == "(label put take a b)"
    assert service.get("a.properties") == "(txt)"
    assert service.get("a.txt") == b"x"
    assert service.get("a.txt.meta.type") == "bytes"
    assert service.get("a.txt.meta.size") == "1"
    assert service.get("a.txt.meta.access") == "rw"
    drawer.take("a.txt")
    assert code(service, "a.txt") == "unknown"
    assert service.get("properties") == "(label put take b)"


def test_a_member_of_the_object_wins(drawer: Drawer) -> None:
    drawer.put("label", "b")
    service = served(drawer)
    assert service.get("label.meta.type") == "string"
    assert service.get("properties") == "(label put take b)"


def test_what_is_not_there_can_be_set(drawer: Drawer) -> None:
    drawer.put("a.b")
    service = served(drawer)
    for name in ("new.jpg", "a", "a.b.c", "b%20c"):
        service.set(name, b"bytes")
        assert service.get(name) == b"bytes"
        assert name in str(service.get("properties?all=1"))
    assert code(service, "nothing", b"") == "denied"
    assert code(service, "note.meta", b"") in ("conflict", "unknown")
    assert code(service, "a?what=1", b"") == "bad-parameter"
    service.set("a?delete=1", b"")
    assert code(service, "a.txt") == "unknown"
    assert service.get("a.b") == b"x"  # what is below stays
    assert code(service, "b?delete=1&offset=1", b"") == "bad-parameter"


def test_below_an_attribute_they_are_of_several_types() -> None:
    service = served(Cabinet())
    assert service.get("levels.high.meta.type") == "number"
    assert service.get("levels.all.meta.type") == "vector"
    assert service.get("levels.all.first") == "1.5"
    assert service.get("levels.all.1") == "2.0"
    assert service.get("levels.high.meta.access") == "r"
    assert code(service, "levels.high", "1") == "read-only"
    assert code(service, "levels.low", "1") == "unknown"
    service.set("drawer.new", b"1")
    assert service.get("drawer.new?offset=1") == b""
    assert code(service, "drawer.new?offset=x") == "bad-parameter"


def test_a_revision_tells_that_a_value_has_changed(drawer: Drawer) -> None:
    drawer.put("a")
    service = served(drawer)
    service.get("a")
    first = service.revision("a")
    service.get("a")
    assert service.revision("a") == first
    drawer._kept["a"] = b"other"
    assert code(service, f"a?if={first}", b"mine") == "conflict"
    service.set(f"a?if={service.revision('a')}", b"mine")
    assert service.get("a") == b"mine"
    assert service.registry.nodes["a"].value is None  # what is read is not kept


class Listening(ListeningRequester):
    def events(self) -> list[tuple[str, str | bytes, str]]:
        found: list[tuple[str, str | bytes, str]] = []
        self.send_due(1e9, lambda: True, lambda _, e: found.append((e.name, e.payload, e.code)))
        return found


def listen(service: Service, target: str) -> Listening:
    caller = Listening("me")
    service.handle(PropertyRequest(target, "self", lambda answer: answer.value(), caller))
    return caller


def test_many_names_are_one_event(drawer: Drawer) -> None:
    service = served(drawer)
    caller = listen(service, "properties.listen?mode=diff&initial=0")
    caller.events()
    drawer.put("a", "b", "c.d")
    service.poll()
    assert caller.events() == [("properties", "((added a b c.d) (removed))", "")]
    drawer.take("a")
    drawer.put("e")
    service.poll()
    assert caller.events() == [("properties", "((added e) (removed a))", "")]


def test_names_are_looked_at_while_they_may_have_changed_only(drawer: Drawer) -> None:
    service = served(drawer)
    listen(service, "properties.listen")
    drawer._is_still = True
    before = drawer._lists
    for _ in range(5):
        service.poll()
    assert drawer._lists == before
    drawer._is_still = False
    service.poll()
    assert drawer._lists > before


def test_a_listened_value_is_read_when_its_stamp_has_changed(drawer: Drawer) -> None:
    drawer.put("a")
    service = served(drawer)
    caller = listen(service, "a.listen")
    assert caller.events() == [("a", b"x", "")]
    reads = drawer._reads
    for _ in range(5):
        service.poll()
    assert drawer._reads == reads
    drawer._kept["a"] = b"new"
    service.poll()
    assert caller.events() == [("a", b"new", "")]
    service.set("a", b"set")
    assert caller.events() == [("a", b"set", "")]
    drawer.take("a")
    service.poll()
    assert caller.events() == [("a", "", "unknown")]


def test_ten_thousand_names_are_listed_fast(drawer: Drawer) -> None:
    drawer.put(*(f"d{n % 100}.f{n}.jpg" for n in range(10_000)))
    begin = time.perf_counter()
    service = served(drawer)
    took_s = time.perf_counter() - begin
    begin = time.perf_counter()
    assert len(str(service.get("properties?depth=3&match=d7.*.jpg"))) > 100
    first_s = time.perf_counter() - begin
    begin = time.perf_counter()
    for _ in range(10):
        service.get("properties")
    again_s = (time.perf_counter() - begin) / 10
    drawer.take(*(f"d{n % 100}.f{n}.jpg" for n in range(5_000)))
    begin = time.perf_counter()
    service.get("properties")
    gone_s = time.perf_counter() - begin
    # Quiet: 90 ms, 20 ms, 0.1 ms, 24 ms; each removal by a walk of all names would take seconds.
    assert took_s < 10.0
    assert again_s < 0.02
    assert max(first_s, gone_s) < 3.0


def test_two_who_list_the_same_new_name_at_once_add_it_once(drawer: Drawer) -> None:
    """One has listed the names, and waits; the other one applies what it has found meanwhile."""
    service = served(drawer)
    has_listed, may_go_on = threading.Event(), threading.Event()
    failures: list[BaseException] = []
    drawer.put("a", "b")
    listed = drawer.names

    def second() -> Collection[str]:
        found = listed()
        if threading.current_thread() is late:
            has_listed.set()
            assert may_go_on.wait(20)
        return found

    def look() -> None:
        try:
            service.values.names_now()
        except PropertyError as error:
            failures.append(error)

    drawer.hint = lambda name: second() and None  # type: ignore[method-assign]
    late = threading.Thread(target=look)
    early_look = service.values.on_names
    assert early_look is not None
    # The first to begin is the first to end, so neither is out of date.
    begun, may_end = threading.Event(), threading.Event()

    def first() -> None:
        drawer.names = begin_first  # type: ignore[method-assign]
        look()

    def begin_first() -> Collection[str]:
        drawer.names = listed  # type: ignore[method-assign]
        begun.set()
        assert may_end.wait(20)
        return listed()

    early = threading.Thread(target=first)
    early.start()
    assert begun.wait(20)
    late.start()
    assert has_listed.wait(20)
    may_end.set()
    early.join()
    may_go_on.set()
    late.join()
    assert not failures
    assert service.get("properties") == "(label put take a b)"


def test_what_went_and_came_while_somebody_looked_comes_with_the_next_look(drawer: Drawer) -> None:
    table = NameTable("", lambda: drawer)
    drawer.put("a", "b")
    first = table.looked()
    assert first is not None
    assert table.put(first) == ([], {"a": None, "b": None})
    drawer.put("c")
    slow = table.looked()
    drawer.take("a")
    quick = table.looked()
    assert slow is not None
    assert quick is not None
    assert table.put(quick) == (["a"], {"c": None})
    assert table.put(slow) == ([], {})
    drawer.put("a")
    again = table.looked()
    assert again is not None
    assert table.put(again) == ([], {"a": None})
    assert table.looked() is None


def test_a_place_that_has_no_names_yet_is_there(drawer: Drawer) -> None:
    class Empty:
        def __init__(self) -> None:
            self.kept = Bare()

    class Bare(Names):
        def __init__(self) -> None:
            self._kept: dict[str, int] = {}

        def names(self) -> Collection[str]:
            return tuple(self._kept)

        def get(self, name: str) -> int:
            return self._kept[name]

        def set(self, name: str, value: int) -> None:
            self._kept[name] = value

    made = Empty()
    service = served(made)
    assert service.get("properties") == "(kept)"
    assert service.get("kept") == "()"
    assert service.get("kept.properties") == "()"
    assert code(service, "kept.a.b") == "unknown"
    service.set("kept.a.b", "1")
    assert service.get("kept.a.b") == "1"
    assert service.get("kept") == "(a)"
    made.kept._kept.clear()
    assert service.get("properties") == "(kept)"
    assert service.get("kept") == "()"
    made.kept._kept["c"] = 3
    assert service.get("kept.c") == "3"
    assert service.get("kept") == "(c)"


class Volume(Names):
    """One number, under a name that stays."""

    def __init__(self) -> None:
        self._names, self._value = ("volume",), 1.0

    def names(self) -> Collection[str]:
        return self._names

    def get(self, name: str) -> float:
        return self._value

    def set(self, name: str, value: float) -> None:
        self._value = value
        if name not in self._names:
            self._names = (*self._names, name)


def test_all_names_are_looked_at_only_after_a_set_that_changed_the_list() -> None:
    service = Service("radio")
    Exported(service, Volume())
    looks: list[str] = []
    looked = service.values.on_names
    assert looked is not None

    def look() -> None:
        looks.append("")
        looked()

    service.values.on_names = look
    service.set("volume", "2")
    assert (service.get("volume"), looks) == ("2.0", [])
    service.set("bass", "3")
    assert (service.get("properties"), bool(looks)) == ("(volume bass)", True)
