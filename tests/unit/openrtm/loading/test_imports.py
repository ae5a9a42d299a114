"""Names of OpenRTM are there for the modules that import them, and for nothing else."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from openrtm_files import made, write_component

from rtkit.errors import Refused
from rtkit.modules.loader import Loader

NAMES = ("OpenRTM_aist", "RTC", "RTC__POA", "omniORB", "CORBA", "helper", "Robot", "Robot_idl")


def test_no_name_enters_the_process(tmp_path: Path) -> None:
    (tmp_path / "helper.py").write_text("import RTC\nKIND = RTC.TimedLong\n", encoding="utf-8")
    write_component(
        tmp_path, "One", "kind = helper.KIND", before="import helper, sys\nsys.path.append('.')\n"
    )
    assert made(tmp_path / "One.py").servant.kind.__name__ == "TimedLong"
    assert [name for name in NAMES if name in sys.modules] == []
    assert "." not in sys.path


def test_a_module_of_rtkit_finds_none_of_them(tmp_path: Path) -> None:
    write_component(tmp_path, "One", "pass")
    made(tmp_path / "One.py")
    file = tmp_path / "native.py"
    file.write_text("import RTC\n\ndef nativeInit(manager):\n    pass\n", encoding="utf-8")
    with pytest.raises(Refused, match="ModuleNotFoundError: No module named 'RTC'"):
        Loader([]).load(str(file))


def test_siblings_of_one_name_are_kept_apart(tmp_path: Path) -> None:
    found = []
    for name in ("a", "b"):
        folder = tmp_path / name
        folder.mkdir()
        (folder / "helper.py").write_text(f"import RTC\nWHERE = {name!r}\n", encoding="utf-8")
        write_component(folder, "One", "where = helper.WHERE", before="import helper\n")
        found.append(made(folder / "One.py").servant.where)
    assert found == ["a", "b"]


def test_packages_beside_a_module_import_relatively(tmp_path: Path) -> None:
    package = tmp_path / "parts"
    package.mkdir()
    (package / "__init__.py").write_text("from .inner import VALUE\n", encoding="utf-8")
    (package / "inner.py").write_text(
        "from . import other\nVALUE = other.VALUE\n", encoding="utf-8"
    )
    (package / "other.py").write_text("import RTC\nVALUE = 7\n", encoding="utf-8")
    body = "values = (VALUE, parts.other.VALUE)"
    before = "import parts.other\nfrom parts import *\nfrom parts.inner import VALUE\n"
    assert made(write_component(tmp_path, "One", body, before=before)).servant.values == (7, 7)


def test_stubs_of_the_files_of_openrtm_itself_are_there(tmp_path: Path) -> None:
    before = "import RTC_idl, DataPort_OpenRTM_idl\nfrom BasicDataType_idl import *\nimport RTC\n"
    assert made(write_component(tmp_path, "One", "kind = RTC.TimedLong", before=before))


def test_tabs_among_spaces_reach_to_the_eighth_column(tmp_path: Path) -> None:
    file = write_component(tmp_path, "Tabs", "def value(self):\n    if True:\n        return 5")
    text = file.read_text(encoding="utf-8").replace("        if True", "\tif True")
    file.write_text(text, encoding="utf-8")
    with pytest.raises(TabError):
        compile(text, "Tabs.py", "exec")
    assert made(file).servant.value() == 5


def test_python_2_is_named_as_such(tmp_path: Path) -> None:
    file = write_component(
        tmp_path, "Old", "pass", before="import OpenRTM_aist\nraise ValueError, 'x'\n"
    )
    with pytest.raises(
        Refused, match=r"not import: .*/Old.py:2 is Python 2 \(raise with a comma\)"
    ):
        Loader([]).load(str(file))


def test_what_older_versions_of_python_had_is_told_with_its_mend(tmp_path: Path) -> None:
    for name, code in (("One", "import time\ntime.clock()\n"), ("Two", "import commands\n")):
        file = write_component(tmp_path, name, "pass", before=code)
        with pytest.raises(Refused, match=f"rtkit openrtm migrate {file} "):
            Loader([]).load(str(file))


def test_a_file_beside_the_module_is_read_by_its_name(tmp_path: Path) -> None:
    (tmp_path / "words.txt").write_text("hello", encoding="utf-8")
    body = "with open('words.txt') as file:\n    text = file.read()"
    assert made(write_component(tmp_path, "One", body)).servant.text == "hello"


def test_what_is_absent_says_so_when_it_is_called(tmp_path: Path) -> None:
    body = """
def onInitialize(self):
    OpenRTM_aist.SdoServiceAdmin.instance()
    return RTC.RTC_OK
"""
    with pytest.raises(
        Refused, match=r"OpenRTM_aist\.SdoServiceAdmin.instance of OpenRTM-aist is not supp"
    ):
        made(write_component(tmp_path, "One", body))


def test_a_type_that_the_standard_lacks_is_no_attribute(tmp_path: Path) -> None:
    with pytest.raises(Refused, match="AttributeError: module 'RTC' has no attribute 'TimedBool'"):
        made(write_component(tmp_path, "One", "kind = RTC.TimedBool"))


def test_an_edit_beside_a_module_is_seen_and_read_again(tmp_path: Path) -> None:
    (tmp_path / "helper.py").write_text("VALUE = 1\n", encoding="utf-8")
    file = write_component(tmp_path, "One", "value = helper.VALUE", before="import helper\n")
    loader = Loader([])
    first = made(file, loader=loader)
    assert (first.servant.value, loader.changed(first.type)) == (1, "")
    (tmp_path / "helper.py").write_text("VALUE = 22\n", encoding="utf-8")
    loader._look_at_s.clear()  # it looks once for all components of a batch
    assert loader.changed(first.type) == str(file)
    loader.unload(str(file))
    assert made(file, loader=loader).servant.value == 22


def test_a_module_that_failed_is_imported_again_once_it_is_mended(tmp_path: Path) -> None:
    (tmp_path / "helper.py").write_text("VALUE = missing\n", encoding="utf-8")
    file = write_component(tmp_path, "One", "value = helper.VALUE", before="import helper\n")
    loader = Loader([])
    with pytest.raises(Refused, match=r"NameError: name 'missing' is not defined \(.*One.py:1\)"):
        loader.load(str(file))
    (tmp_path / "helper.py").write_text("VALUE = 3\n", encoding="utf-8")
    assert made(file, loader=loader).servant.value == 3


def test_a_folder_in_a_package_beside_a_module_is_part_of_it(tmp_path: Path) -> None:
    inner = tmp_path / "tools" / "inner"
    inner.mkdir(parents=True)
    (tmp_path / "tools" / "__init__.py").write_text("", encoding="utf-8")
    (inner / "part.py").write_text("NUMBER = 7\n", encoding="utf-8")
    file = write_component(tmp_path, "One", "pass", before="from tools.inner.part import NUMBER\n")
    assert made(file).type.type_name == "One"
