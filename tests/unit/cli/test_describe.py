"""What ``rtcat`` unfolds: connections, properties, participants, interfaces."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from textwrap import dedent
from typing import Any

from fake_manager import FakeManager

from rtkit.rtc.enums import ExecutionKind
from rtkit.rtc.profiles import ConnectorProfile, ModuleProfile, PortRef

Run = Callable[[str], Any]


def wire(world: FakeManager, connector_id: str, *ends: tuple[str, str], **properties: str) -> None:
    ports = tuple(PortRef(*end) for end in ends)
    world.connectors[connector_id] = ConnectorProfile(connector_id, "in_out", ports, properties)


def test_old_code_is_told(world: FakeManager, run: Run, tmp_path: Path) -> None:
    file = tmp_path / "Motor.py"
    file.write_text("edited since")
    path = next(iter(world.shell.state.components.values())).names[0]
    assert "Code" not in run(f"rtcat /{path}").out
    world.update(path.rpartition("/")[2].removesuffix(".rtc"), code=f"00000000 {file}")
    assert f"changed since it was loaded ({file})" in run(f"rtcat /{path}").out
    file.unlink()  # whether it has changed is not known
    assert "changed since" not in run(f"rtcat /{path}").out


def test_connections_are_folded_at_level_one(world: FakeManager, run: Run) -> None:
    wire(world, "w", ("Output0", "out"), ("Std0", "in"))
    assert run("rtcat -l /localhost/Std0.rtc:in").out == dedent("""\
        -DataInPort: in
          dataport.data_type  IDL:RTC/TimedLong:1.0
         +Connected to  /localhost/local.host_cxt/Output0.rtc:out
        """)


def test_connections_are_unfolded_at_level_two(world: FakeManager, run: Run) -> None:
    wire(
        world,
        "connection_id0",
        ("Output0", "out"),
        ("Std0", "in"),
        **{
            "dataport.subscription_type": "new",
            "dataport.corba_cdr.inport_ior": "IOR:0123",
            "a": "1",
        },
    )
    assert run("rtcat -ll /localhost/Std0.rtc:in").out == dedent("""\
        -DataInPort: in
          dataport.data_type  IDL:RTC/TimedLong:1.0
         -Connected to  /localhost/local.host_cxt/Output0.rtc:out
          Name                        in_out
          ID                          connection_id0
          a                           1
          dataport.subscription_type  new
        """)


def test_third_parties_are_aligned_under_the_first(world: FakeManager, run: Run) -> None:
    wire(world, "w", ("Std0", "out"), ("Input0", "in"), ("Err0", "in"))
    assert run("rtcat -l /localhost/Std0.rtc:out").out == dedent("""\
        -DataOutPort: out
          dataport.data_type  IDL:RTC/TimedLong:1.0
         +Connected to  /localhost/Input0.rtc:in
                        /localhost/Err0.rtc:in
        """)


def test_ports_that_nobody_knows_are_counted(world: FakeManager, run: Run) -> None:
    wire(world, "w", ("Std0", "out"), ("Far0", "in"))
    assert run("rtcat -l /localhost/Std0.rtc:out").out.splitlines()[-1] == " (1 other connection)"
    wire(world, "v", ("Std0", "out"), ("Far1", "in"))
    assert run("rtcat -l /localhost/Std0.rtc:out").out.splitlines()[-1] == " (2 other connections)"


def test_a_component_without_name_is_told_by_its_manager(world: FakeManager, run: Run) -> None:
    world.update("Output0", names=())
    wire(world, "w", ("Output0", "out"), ("Std0", "in"))
    assert "/localhost/manager.mgr/Output0.rtc:out" in run("rtcat -l /localhost/Std0.rtc:in").out


def test_properties_and_participants_unfold(world: FakeManager, run: Run) -> None:
    (context,) = world.components["Std0"].contexts
    changed = replace(
        context,
        kind=ExecutionKind.EVENT_DRIVEN,
        is_running=False,
        participants=("Err0", "Text0"),
        properties={"sync": "yes"},
    )
    world.update("Std0", contexts=(changed,), properties={"naming.formats": "%n.rtc"}, ports=())
    folded = run("rtcat -l /localhost/Std0.rtc").out
    assert folded.splitlines()[8:] == [
        " +Extra properties",
        "-Execution Context 0",
        "  State  Stopped",
        "  Kind   Event-driven",
        "  Rate   1000.0",
        "  Owner  Std0",
        " +Participants",
        " +Extra properties",
    ]
    unfolded = run("rtcat -ll /localhost/Std0.rtc").out
    assert unfolded.splitlines()[8:] == [
        " -Extra properties",
        "  naming.formats  %n.rtc",
        "-Execution Context 0",
        "  State  Stopped",
        "  Kind   Event-driven",
        "  Rate   1000.0",
        "  Owner  Std0",
        " -Participants",
        "  Err0",
        "  Text0",
        " -Extra properties",
        "  sync  yes",
    ]


def test_a_manager_tells_its_modules(world: FakeManager, run: Run) -> None:
    world.properties.update(
        {"manager.modules.load_path": "/mods", "os.name": "Linux", "manager.name": "manager"}
    )
    world.loaded["/mods/a.py"] = ModuleProfile(
        "/mods/a.py", "aInit", (world.types["Std"].type, world.types["Output"].type)
    )
    world.loadable = (
        "RTC:Me:test:Std:Python:1.0?module=/mods/a.py\nRTC:Me:test:New:Python:2.0?module=/mods/n.py"
    )
    lines = run("rtcat /localhost/manager.mgr").out.splitlines()
    assert lines[:3] == ["Name: manager", "Instance name: manager", f"Process ID: {os.getpid()}"]
    assert "  Load path: /mods" in lines
    assert "  Name: Linux" in lines
    assert lines[-6:] == [
        "Loaded modules:",
        "  Filepath: /mods/a.py",
        "Loadable modules:",
        "  RTC:Me:test:New:Python:2.0",
        "  RTC:Me:test:Output:Python:1.0",
        "  RTC:Me:test:Std:Python:1.0",
    ]


def test_a_property_s_last_character_may_be_a_blank(world: FakeManager, run: Run) -> None:
    world.update("Std0", properties={"note": "\u3000wide\u3000"})
    assert "  note  \u3000wide\n" in run("rtcat -ll /localhost/Std0.rtc").out
