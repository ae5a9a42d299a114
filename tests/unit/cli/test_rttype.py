"""Types of modules, IDL files, recordings and ports of a system, as ``rttype`` tells them."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from fake_manager import FakeManager

from rtkit.component.values.codec import codec_for
from rtkit.component.values.defined import class_of
from rtkit.component.values.literal import Literal
from rtkit.recording.entries import RecordedStream, RecordedValue
from rtkit.recording.mcap_file import RecordingWriter
from rtkit.rtc.enums import PortType
from rtkit.rtc.profiles import DEFINITION, PortProfile

Run = Callable[[str], Any]
IDL = """#include "part.idl"
module Robot {
  enum Mode { IDLE, DRIVE };
  exception Busy { string why; };
  // A wheel.
  struct Wheel {
    @unit("m/s") double speed;  // at the rim
    sequence<Part::Bolt> bolts;
  };
  union Odd switch (long) { case 1: long x; };
  struct Holder { Odd odd; };
  interface Base { void stop(); };
};
"""
PART = "module Part { struct Bolt { long size[2]; string name; }; };"
OTHER = "module Robot {\n  struct Wheel {\n    float speed;\n  };\n};\n"


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("RTKIT_MODULE_PATH", raising=False)
    (tmp_path / "idl").mkdir()
    (tmp_path / "idl" / "Robot.idl").write_text(IDL)
    (tmp_path / "idl" / "part.idl").write_text(PART)
    return tmp_path


def give_port(world: FakeManager, name: str, definition: str) -> None:
    """Have Std0 tell a port of that type."""
    properties = {"dataport.data_type": f"IDL:{name}:1.0"}
    properties |= {DEFINITION: definition} if definition else {}
    world.update("Std0", ports=(PortProfile("own", PortType.OUT, properties),))


def shown(run: Run, line: str) -> dict[str, Any]:
    done = run(f"rttype show --json {line}")
    assert (done.status, done.err) == (0, "")
    record: dict[str, Any] = json.loads(done.out)
    return record


def test_types_of_idl_files_are_listed_with_their_files(run: Run) -> None:
    assert run("rttype list 'Robot::*' Bolt").out.splitlines() == [
        "Part::Bolt     struct     idl/part.idl",
        "Robot::Base    interface  idl/Robot.idl",
        "Robot::Holder  struct     idl/Robot.idl",
        "Robot::Mode    enum       idl/Robot.idl",
        "Robot::Wheel   struct     idl/Robot.idl",
    ]


def test_a_page_tells_fields_units_size_and_a_value_that_can_be_injected(run: Run) -> None:
    page = shown(run, "Robot::Wheel")
    assert page["fields"] == [
        {"name": "speed", "type": "double", "about": "at the rim [m/s]"},
        {"name": "bolts", "type": "sequence<Part::Bolt>", "about": ""},
    ]
    assert (page["size_bytes"], page["is_fixed_size"], page["source"]) == (
        16,
        False,
        "idl/Robot.idl",
    )
    assert (
        "  // A wheel.\n  struct Wheel {\n    double speed;  // at the rim [m/s]"
        in page["definition"]
    )
    assert page["example"] == {"speed": 0.0, "bolts": [{"size": [0, 0], "name": ""}]}
    Literal(class_of("Robot::Wheel", page["definition"]), json.dumps(page["example"]))
    assert shown(run, "Mode")["fields"][1] == {"name": "DRIVE", "type": "1", "about": ""}


def test_what_cannot_be_carried_is_known_by_name(run: Run) -> None:
    done = run("rttype show Robot::Holder")
    assert done == (0, "// Robot::Holder, idl/Robot.idl\n// nothing here has its IDL\n", "")


def test_a_live_type_comes_before_a_file_and_a_difference_is_told(
    run: Run, world: FakeManager
) -> None:
    give_port(world, "Robot/Wheel", OTHER)
    done = run("rttype show Wheel")
    assert done.out.startswith("// Robot::Wheel, live: /localhost/Std0.rtc:own\nmodule Robot {\n")
    assert "float speed;" in done.out
    assert done.err == "rttype: warning: Robot::Wheel is another one in idl/Robot.idl\n"
    assert "double speed;" in run("rttype show -f idl/Robot.idl Wheel").out


def test_a_type_inside_of_another_one_is_found(run: Run, world: FakeManager) -> None:
    give_port(world, "Far/Outer", "module Far { struct In { long x; }; struct Outer { In i; }; };")
    assert shown(run, "Far::In")["size_bytes"] == 8


def test_a_port_whose_type_nobody_tells_is_listed_and_found(run: Run, world: FakeManager) -> None:
    give_port(world, "Far/Off", "")
    assert run("rttype list 'Far::*'").out == "Far::Off  struct  live  1 port\n"
    assert run("rttype find-ports Off").out == "/localhost/Std0.rtc:own  out\n"
    assert run("rttype show Off").out.endswith("// nothing here has its IDL\n")


def test_a_definition_that_makes_no_class_is_shown_as_it_is(run: Run, world: FakeManager) -> None:
    text = "module Far { struct T; struct T { sequence<T> x; }; };"
    give_port(world, "Far/T", text)
    assert run("rttype show Far::T").out.splitlines()[1:] == [text]


def test_a_file_that_cannot_be_read_is_a_warning(run: Run, folder: Path) -> None:
    (folder / "a.idl").mkdir()
    (folder / "b.idl").symlink_to("/proc/self/mem")
    done = run("rttype show -q Wheel")
    assert (done.status, done.out) == (0, "Robot::Wheel\n")
    assert done.err.startswith("rttype: warning: ")


def test_a_short_name_of_two_types_is_refused(run: Run, folder: Path) -> None:
    (folder / "a.idl").write_text("module A { struct Bolt { long x; }; };")
    done = run("rttype show Bolt")
    assert (done.status, done.err) == (1, "rttype: Bolt may be A::Bolt or Part::Bolt\n")


def test_types_of_a_recording(run: Run, folder: Path) -> None:
    cls = class_of("Robot::Wheel", OTHER)
    with open("run.mcap", "wb") as file, RecordingWriter(file) as writer:
        writer.add_channel(RecordedStream("a", "IDL:Robot/Wheel:1.0"), cls)
        writer.add_channel(RecordedStream("b", "IDL:Robot/Odd:1.0"), bytes)
        writer.write(RecordedValue("a", 1, 1, codec_for(cls).encode(cls())))
    (folder / "idl" / "Robot.idl").unlink()
    page = shown(run, "-f run.mcap Wheel")
    assert (page["source"], page["size_bytes"], page["is_fixed_size"]) == ("run.mcap", 8, True)
    assert run("rttype list -q -f run.mcap 'Robot::*'").out == "Robot::Odd\nRobot::Wheel\n"


def test_types_of_a_module(run: Run, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "mod").mkdir()
    (folder / "mod" / "own_types.py").write_text(
        "from dataclasses import dataclass\nfrom enum import Enum\n"
        "@dataclass(frozen=True)\nclass Spot:\n    x: float = 0.0\n"
        "@dataclass\nclass Odd:\n    f: complex = 1j\n"
        "class Way(Enum):\n    A = 3\n"
    )
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.delitem(sys.modules, "own_types", raising=False)
    line = "rttype list -p mod -m own_types 'own_types::*'"
    assert run(line).out.splitlines() == [
        "own_types::Spot  struct  module own_types",
        "own_types::Way   enum    module own_types",
    ]


def test_a_file_that_is_none_of_idl_is_a_warning_unless_it_was_named(
    run: Run, folder: Path
) -> None:
    (folder / "bad.idl").write_text("struct Broken {")
    done = run("rttype show -q Wheel")
    assert (done.status, done.out) == (0, "Robot::Wheel\n")
    assert done.err.startswith("rttype: warning: bad.idl:1: ")
    named = run("rttype show -q -f bad.idl Wheel")
    assert (named.status, named.out) == (1, "")
    assert named.err.startswith("rttype: bad.idl:1: ")
