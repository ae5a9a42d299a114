"""Ports that come while a recorder runs: which are connected, and when."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import pytest
from fake_manager import FakeManager
from fake_tree import fake_tree

from rtkit.api import late_ports
from rtkit.api.late_ports import LatePorts
from rtkit.api.observers import ObservedEvent
from rtkit.deployment.actions import Create
from rtkit.deployment.facts import RestartStatus
from rtkit.deployment.user_events import TREE_EVENT, UserEvent
from rtkit.fast_dataclass import replace
from rtkit.probe.port_spec import Stream, parse_spec
from rtkit.rtc.enums import PortType
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.profiles import ConnectorProfile, PortProfile, PortRef, TypeProfile
from rtkit.tree.subscription import TreeChange

_OUT = PortProfile("out", PortType.OUT, {"dataport.data_type": "IDL:RTC/TimedLong:1.0"})
_FAR = PortProfile("out", PortType.OUT, {"dataport.data_type": "IDL:RTC/TimedDouble:1.0"})


class Recorder:
    """A probe of nothing, whose component is known at once."""

    def __init__(self, world: FakeManager) -> None:
        world_tree = fake_tree(world)
        world_tree.perform(Create("Tool?instance_name=rec"))
        self.component = SimpleNamespace(instance="rec", notify=None)
        self.joined: list[str] = []
        self.ports: list[PortProfile] = []

    def extend(self, ports: Any) -> None:
        self.ports += [each.profile for each in ports]

    def join(self, _tree: Any, streams: list[Stream], _refused: Any) -> None:
        self.joined += [f"{each.name}={each.ends[0].ref}" for each in streams]


class Bench:
    """A manager, a recorder of ``S*:out``, and a clock."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        types = [
            ComponentPattern(TypeProfile("S"), (_OUT,)),
            ComponentPattern(TypeProfile("Sfar"), (_FAR,)),
            ComponentPattern(TypeProfile("Tool", "rtkit", "tool"), ()),
        ]
        self.world = FakeManager(types)
        self.tree = fake_tree(self.world)
        self.recorder = Recorder(self.world)
        self.now = 0.0
        self.connectors: tuple[ConnectorProfile, ...] = ()
        self.restarts: dict[str, int] = {}
        self.added: list[str] = []
        bench = self

        class Observers:
            def __init__(self, *_arguments: Any) -> None: ...

            @property
            def subscriptions(self) -> Any:
                return {"": SimpleNamespace(facts=bench.facts())}

            def listen(self, *_arguments: Any) -> Iterator[list[Any]]:
                yield []

            def close(self) -> None: ...

        monkeypatch.setattr(late_ports, "Observers", Observers)
        monkeypatch.setattr(late_ports, "monotonic", lambda: self.now)
        app: Any = SimpleNamespace(tree=self.tree, verbose=lambda _: None, fail=pytest.fail)
        probe: Any = self.recorder
        self.late = LatePorts(
            app,
            probe,
            [parse_spec("S*:out")],
            [],
            lambda _number, ref: f"{ref.instance}_{ref.port}",
            pytest.fail,
            lambda stream: self.added.append(stream.name),
        )

    def facts(self) -> Any:
        """What the manager knows, with the present ports, connectors and restarts."""
        snapshot = self.tree.snapshot()
        found = []
        for each in snapshot.components:
            status = RestartStatus(restarts=self.restarts.get(each.instance, 0))
            ports = tuple(self.recorder.ports) if each.instance == "rec" else each.ports
            found.append(replace(each, ports=ports, restart_status=status))
        return replace(snapshot, components=tuple(found), connectors=self.connectors)

    def look(self) -> list[str]:
        """Have it look, as its timer does, and return what was connected."""
        self.recorder.joined.clear()
        self.late._look()
        self.late._look()
        return list(self.recorder.joined)


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Bench:
    return Bench(monkeypatch)


def test_a_port_that_comes_is_connected_once(bench: Bench) -> None:
    assert bench.look() == []
    bench.tree.perform(Create("S?instance_name=S0"))
    assert bench.look() == ["S0_out=S0.out"]
    assert bench.look() == []
    assert bench.added == ["S0_out"]


def test_a_component_that_was_removed_and_made_again_is_the_same_stream(bench: Bench) -> None:
    bench.tree.perform(Create("S?instance_name=S0"))
    bench.look()
    bench.tree.delete("/localhost/S0.rtc")
    assert bench.look() == []
    bench.tree.perform(Create("S?instance_name=S0"))
    assert bench.look() == ["S0_out=S0.out"]
    assert bench.added == ["S0_out"]


def test_one_that_has_gone_and_is_back_before_the_next_look_is_connected_again(
    bench: Bench,
) -> None:
    bench.tree.perform(Create("S?instance_name=S0"))
    bench.look()
    gone = UserEvent(TREE_EVENT, "S0", "manager", "", "VANISHED")
    bench.late._forget_gone([ObservedEvent("", TreeChange(0.0, (gone,)))])
    assert bench.look() == ["S0_out=S0.out"]
    other = UserEvent(TREE_EVENT, "S1", "manager", "", "VANISHED")
    bench.late._forget_gone([ObservedEvent("", TreeChange(0.0, (other,)))])
    assert bench.look() == []


def test_another_type_under_the_same_name_is_another_stream(bench: Bench) -> None:
    bench.tree.perform(Create("S?instance_name=S0"))
    bench.look()
    bench.tree.delete("/localhost/S0.rtc")
    bench.look()
    bench.tree.perform(Create("Sfar?instance_name=S0"))
    assert bench.look() == ["S0_out_=S0.out"]
    assert bench.added == ["S0_out", "S0_out_"]


def test_a_connection_that_the_manager_restores_is_not_made_twice(bench: Bench) -> None:
    bench.tree.perform(Create("S?instance_name=S0"))
    bench.look()
    bench.tree.delete("/localhost/S0.rtc")
    bench.look()
    bench.tree.perform(Create("S?instance_name=S0"))
    bench.restarts["S0"] = 1
    assert bench.look() == []
    bench.connectors = (
        ConnectorProfile("x", "", (PortRef("S0", "out"), PortRef("rec", "S0_out"))),
    )
    bench.now = 2.0
    assert bench.look() == []


def test_a_connection_that_the_manager_does_not_restore_is_made_after_a_while(bench: Bench) -> None:
    bench.tree.perform(Create("S?instance_name=S0"))
    bench.look()
    bench.tree.delete("/localhost/S0.rtc")
    bench.look()
    bench.tree.perform(Create("S?instance_name=S0"))
    bench.restarts["S0"] = 1
    assert bench.look() == []
    bench.now = 2.0
    assert bench.look() == ["S0_out=S0.out"]
