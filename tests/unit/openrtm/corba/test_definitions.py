"""Modules for the IDL files beside components."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest
from openrtm_files import made, write_component

from rtkit.component.ports.data_port import DataPort
from rtkit.component.values.definition import definition_of
from rtkit.errors import Refused
from rtkit.idl.model import StructDeclaration
from rtkit.openrtm.corba.definition_files import read_all

IDL = """
#include <BasicDataType.idl>
module Robot {
  enum Mode { IDLE, BUSY };
  const long MOST = 7;
  typedef sequence<double> Numbers;
  struct Arm { RTC::Time tm; Numbers joints; Mode mode; double pose[2]; };
  exception Lost { string why; };
  interface Base { long ask(in string what) raises (Lost); };
  interface Hand : Base { enum Grip { SOFT, HARD }; void hold(in Grip grip); };
};
module RTC { struct Extra { RTC::Time tm; short data; }; };
"""
BODY = """
def __init__(self, manager):
    OpenRTM_aist.DataFlowComponentBase.__init__(self, manager)
    self.d = OpenRTM_aist.instantiateDataType(Robot.Arm)
    self.out = OpenRTM_aist.OutPort("out", self.d)
    self.extra = OpenRTM_aist.OutPort("extra", RTC.Extra(RTC.Time(0, 0), 1))

def onInitialize(self):
    self.addOutPort("out", self.out)
    self.addOutPort("extra", self.extra)
    self.found = (Robot.MOST, str(Robot.BUSY), Robot.Mode, Robot.Hand.HARD, Robot.Numbers)
    try:
        raise Robot.Lost("gone")
    except Robot.Lost as error:
        self.why = error.why
    self.servant = type("Mine", (Robot__POA.Hand,), {})()
    return RTC.RTC_OK
"""
BEFORE = "import Robot_idl\nimport Robot, Robot__POA\n"


def test_an_idl_file_counts_before_what_was_generated_of_it(tmp_path: Path) -> None:
    folder = tmp_path / "idl"
    folder.mkdir()
    (folder / "Robot.idl").write_text(IDL, encoding="utf-8")
    (tmp_path / "Robot_idl.py").write_text("import omniORB, _omnipy\n", encoding="utf-8")
    component = made(write_component(tmp_path, "One", BODY, before=BEFORE))
    servant = component.servant
    assert servant.found[:2] == (7, "BUSY")
    assert servant.why == "gone"
    assert isinstance(servant.servant, servant.servant.__class__.__mro__[2])
    assert (servant.d.joints, str(servant.d.mode), servant.d.pose) == ([], "IDLE", [0.0, 0.0])
    out, extra = component.ports["out"], component.ports["extra"]
    assert isinstance(out, DataPort)
    assert isinstance(extra, DataPort)
    assert out.properties["dataport.data_type"] == "IDL:Robot/Arm:1.0"
    assert "double pose[2]" in definition_of(out.data_type)
    assert extra.properties["dataport.data_type"] == "IDL:RTC/Extra:1.0"


def test_folders_share_the_types_that_they_declare_alike(tmp_path: Path) -> None:
    types = []
    for name in ("a", "b"):
        folder = tmp_path / name
        folder.mkdir()
        (folder / "Robot.idl").write_text(IDL, encoding="utf-8")
        port = made(write_component(folder, "One", BODY, before=BEFORE)).ports["out"]
        assert isinstance(port, DataPort)
        types.append(port.data_type)
    assert types[0] is types[1]


def test_definitions_are_read_once_for_all_processes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    file, other = tmp_path / "a.idl", tmp_path / "inner.idl"
    file.write_text('#include "inner.idl"\nstruct A { B b; };', encoding="utf-8")
    other.write_text("struct B { long one; };", encoding="utf-8")

    def fields() -> list[str]:
        found = read_all(str(tmp_path), [str(file)], lambda path: Path(path).read_bytes())
        declared = found.definitions.find("B")
        assert isinstance(declared, StructDeclaration)
        return [each.name for each in declared.fields]

    assert fields() == ["one"]
    kept = tmp_path / "__pycache__" / "definitions.rtkit.pickle"
    with monkeypatch.context() as no_parser:
        no_parser.setattr("rtkit.idl.read.read_idl", None)
        assert fields() == ["one"]
    other.write_text("struct B { long two; };", encoding="utf-8")
    assert fields() == ["two"]
    kept.write_bytes(kept.read_bytes()[:40])
    assert fields() == ["two"]


def test_a_definition_that_cannot_be_read_is_named_where_it_is_missed(tmp_path: Path) -> None:
    (tmp_path / "Bad.idl").write_text("module Bad { struct A { nothing x; }; };", encoding="utf-8")
    before = "import Bad_idl\nimport Bad\n"
    with pytest.raises(Refused, match=r"Bad.A is not there: .*Bad.idl:1: .*nothing"):
        made(write_component(tmp_path, "One", "kind = Bad.A", before=before))


def test_idl_files_elsewhere_are_found_by_the_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    beside, elsewhere = tmp_path / "beside", tmp_path / "elsewhere"
    beside.mkdir()
    elsewhere.mkdir()
    (elsewhere / "Robot.idl").write_text(IDL, encoding="utf-8")
    before = "import Robot\nimport Robot_idl, Robot__POA\n"
    body = """
def onInitialize(self):
    self.most, self.base = Robot.MOST, Robot__POA.Hand
    return RTC.RTC_OK
"""
    where = f"{beside}, {beside}/\\*, {tmp_path}/idl; RTM_IDL_PATH=FOLDER names further folders"
    with pytest.raises(Refused, match=f"IDL file that declares module Robot in {where}"):
        made(write_component(beside, "One", body, before=before))
    monkeypatch.setenv("RTM_IDL_PATH", f"{tmp_path / 'none'}{os.pathsep}{elsewhere}")
    other = tmp_path / "other"
    other.mkdir()
    servant = made(write_component(other, "Two", body, before=before)).servant
    assert servant.most == 7
    assert servant.base.__name__ == "Hand"


@pytest.mark.parametrize(
    ("before", "why"),
    [
        ("import Gripper_idl\n", "named 'Gripper_idl': there is no Gripper.idl in"),
        ("import Gripper__POA\n", "no IDL file that declares module Gripper in"),
        (
            "from Gripper import *\nimport Gripper_idl\n",
            "no IDL file that declares module Gripper in",
        ),
        ("import Gripper\n'Gripper::Hand'\n", "no IDL file that declares module Gripper in"),
        ("import Gripper\n", r"named 'Gripper' \("),
    ],
)
def test_a_module_that_no_idl_file_declares_is_told_as_such(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, before: str, why: str
) -> None:
    monkeypatch.setenv("RTM_IDL_PATH", str(tmp_path / "none"))
    with pytest.raises(Refused, match=f"ModuleNotFoundError: No module .*{why}") as told:
        made(write_component(tmp_path, "One", "pass", before=before))
    assert (f"{tmp_path}/none (no folder);" in str(told.value)) is ("IDL" in str(told.value))


def test_a_module_that_may_be_missing_is_found_missing_by_its_component(tmp_path: Path) -> None:
    before = "try:\n    import Gripper_idl\nexcept ImportError as error:\n    why = error.name\n"
    component = made(write_component(tmp_path, "One", "missing = why", before=before))
    assert component.servant.missing == "Gripper_idl"
