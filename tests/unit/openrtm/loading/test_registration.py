"""Where modules for OpenRTM-aist register their components, and what is told where they do not."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtkit.errors import NotFound
from rtkit.modules.loader import Loader

MODULE = """
import sys
import OpenRTM_aist
import RTC

spec = ["implementation_id", "Lamp", "type_name", "Lamp", ""]


class Lamp(OpenRTM_aist.DataFlowComponentBase):
    pass


{main}
"""
REGISTERS = """
    manager.registerFactory(OpenRTM_aist.Properties(defaults_str=spec), Lamp, OpenRTM_aist.Delete)
"""
MAIN = """
def main():
    manager = OpenRTM_aist.Manager.init(sys.argv)
    manager.activateManager()
    {registers}
    component = manager.createComponent("Lamp")
    component.get_owned_contexts()[0].activate_component(component.getObjRef())
    manager.runManager()
    raise AssertionError("the component is to live in this process")
"""
INNER = """
def main():
    def begin(manager):
        {registers}
        manager.createComponent("Lamp")

    manager = OpenRTM_aist.Manager.init(len(sys.argv), sys.argv)
    manager.setModuleInitProc(begin)
    manager.activateManager()
    manager.runManager()
"""
GUARDED = """
if __name__ == "__main__":
    manager = OpenRTM_aist.Manager.init(sys.argv)
    manager.activateManager()
    {registers}
    manager.runManager()
"""


def written(folder: Path, main: str) -> Path:
    file = folder / "Lamp.py"
    file.write_text(MODULE.format(main=main.format(registers=REGISTERS.strip())))
    return file


@pytest.mark.parametrize("main", [MAIN, INNER])
def test_a_main_function_registers_and_is_left_where_it_would_run(
    tmp_path: Path, main: str
) -> None:
    (type_,) = Loader([]).load(str(written(tmp_path, main))).types
    assert type_.type_name == "Lamp"


def test_nothing_is_left_of_it_for_other_modules(tmp_path: Path) -> None:
    loader = Loader([])
    loader.load(str(written(tmp_path, MAIN)))
    other = tmp_path / "Other.py"
    other.write_text("import OpenRTM_aist\n\nOpenRTM_aist.Manager.init([])\n")
    with pytest.raises(Exception, match=r"Manager.init in a module that a manager loads"):
        loader.load(str(other))


@pytest.mark.parametrize(
    ("main", "told"),
    [
        (GUARDED, "it registers when it is run (rtkit openrtm run {file})"),
        ("", "it registers no component (rtkit openrtm run {file})"),
    ],
)
def test_a_module_that_registers_nowhere_else_says_how_it_is_run(
    tmp_path: Path, main: str, told: str
) -> None:
    file = written(tmp_path, main)
    with pytest.raises(NotFound) as raised:
        Loader([]).load(str(file))
    assert str(raised.value) == f"no init function LampInit in module {file}: " + told.format(
        file=file
    )


def test_one_that_is_called_by_a_wrong_name_is_asked_for_by_the_right_one(tmp_path: Path) -> None:
    file = written(tmp_path, "def LampInit(manager):\n    {registers}\n")
    with pytest.raises(NotFound, match=r"LimpInit \(did you mean LampInit\?\)"):
        Loader([]).load(str(file), "LimpInit")


def test_one_that_is_called_by_quite_another_name_tells_what_registers(tmp_path: Path) -> None:
    file = written(tmp_path, "def begin(manager):\n    {registers}\n")
    with pytest.raises(NotFound, match=r": say \S+/Lamp.py:LampInit, which finds"):
        Loader([]).load(str(file), "SwitchInit")
