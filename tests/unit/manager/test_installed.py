"""Modules of installed packages: found by entry points, read and not run."""

from __future__ import annotations

import sys
from importlib.machinery import ModuleSpec

import pytest

from rtkit.component.describe import describe
from rtkit.errors import NotFound, Refused
from rtkit.manager.query_server import loadable
from rtkit.modules.loader import Loader
from rtkit.modules.search import Search, installed
from rtkit.rtc.create import parse_create

CODE = """
import os
os.environ["RTKIT_TEST_RAN"] = "{name}"
from rtkit.component import Component
class {name}(Component):
    \"\"\"Installed.\"\"\"
    vendor = "me"
def {init}(manager):
    manager.register_factory({name})
"""


@pytest.fixture
def site(tmp_path, monkeypatch):
    """A folder of installed packages."""
    folder = tmp_path / "site"
    folder.mkdir()
    monkeypatch.syspath_prepend(folder)
    monkeypatch.setenv("RTKIT_TEST_RAN", "")  # what the code sets is undone, too
    monkeypatch.delenv("RTKIT_TEST_RAN")
    return folder


def install(site, entries, files=(), package="some-1.0.dist-info"):
    (site / package).mkdir(exist_ok=True)
    (site / package / "entry_points.txt").write_text(entries)
    for name in files:
        place = site / name
        place.parent.mkdir(parents=True, exist_ok=True)
        stem = place.stem
        place.write_text(CODE.format(name=stem, init=f"{stem}Init"))


def test_entry_points_name_modules(site):
    install(
        site,
        "[console_scripts]\nx = x:y\n\n[ rtkit.components ]\n# none\nScale = Scale:ScaleInit\n"
        "my comp = inner.deep.Other : OtherInit [extra]\nbad\nnone = nix:Init\nos = os:getcwd\n"
        "[other]\nScale2 = Scale:ScaleInit\n",
        ["Scale.py", "inner/deep/Other.py"],
    )
    (site / "inner" / "__init__.py").write_text("import os\nos.environ['RTKIT_TEST_RAN'] = '1'\n")
    found = installed()
    assert found["Scale"] == (str(site / "Scale.py"), "", "ScaleInit", "", "")
    assert found["my comp"] == (
        str(site / "inner/deep/Other.py"),
        "",
        "OtherInit",
        "inner.deep",
        "",
    )
    assert found["my comp"].name == "inner.deep.Other"
    assert not {"x", "bad", "none", "Scale2"} & set(found)
    assert "inner" not in sys.modules


def test_the_first_of_one_name_counts(site, tmp_path, monkeypatch):
    install(site, "[rtkit.components]\nScale = Scale:ScaleInit\n", ["Scale.py"])
    other = tmp_path / "other"
    other.mkdir()
    monkeypatch.syspath_prepend(other)
    install(other, "[rtkit.components]\nScale = Scale:ScaleInit\n", ["Scale.py"])
    assert installed()["Scale"].file == str(other / "Scale.py")


def test_editable_installations_are_asked_where_a_module_is(site, tmp_path, monkeypatch):
    install(site, "[rtkit.components]\nFar = Far:FarInit\n")
    install(tmp_path / "src", "", ["Far.py"])

    class Finder:
        @staticmethod
        def find_spec(name, path=None, target=None):
            if name != "Far":
                return None
            spec = ModuleSpec(name, None, origin=str(tmp_path / "src" / "Far.py"))
            spec.has_location = True
            return spec

    monkeypatch.setattr(sys, "meta_path", [*sys.meta_path, Finder])
    assert installed()["Far"].file == str(tmp_path / "src" / "Far.py")


@pytest.fixture(autouse=True)
def src(tmp_path):
    (tmp_path / "src").mkdir()


def test_what_cannot_be_read_is_passed_over(site):
    (site / "a-1.dist-info").mkdir()
    (site / "b-1.dist-info").mkdir()
    (site / "b-1.dist-info" / "entry_points.txt").write_bytes(b"[rtkit.components]\n\xff = a:b\n")
    (site / "c-1.dist-info").write_text("no folder")
    assert not {name for name in installed() if installed()[name].file.startswith(str(site))}


def test_a_type_is_made_from_an_installed_package_by_its_name(site, tmp_path):
    install(site, "[rtkit.components]\nScale = Scale:ScaleInit\n", ["Scale.py"])
    folder = tmp_path / "modules"
    folder.mkdir()
    loader = Loader([str(folder)])
    made = loader.make(parse_create("Scale"))
    assert made.type.id == "RTC:me::Scale:"
    with pytest.raises(NotFound, match="did you mean Scale"):
        loader.make(parse_create("Scala"))


def test_a_name_and_an_init_function_of_their_own(site):
    install(site, "[rtkit.components]\nmy.scale = inner.Scale:ScaleInit\n", ["inner/Scale.py"])
    loader = Loader([])
    assert loader.load("my.scale").init == "ScaleInit"
    assert [each.type_name for each in loader.factories.types] == ["Scale"]


def test_a_module_found_by_its_type_is_named_as_python_does(site, tmp_path):
    install(site, "[rtkit.components]\nScale = inner.Scale:ScaleInit\n", ["inner/Scale.py"])
    loader = Loader([])
    loader.make(parse_create("Scale"))
    (module,) = loader.found()
    assert (module.path, module.init) == ("inner.Scale", "ScaleInit")
    assert loader.load("Scale.py") is loader.load("inner.Scale", "ScaleInit") is module
    assert module.is_at("Scale.py")
    install(tmp_path, "", ["Scale.py"])  # one in a load path is another one
    assert Loader([str(tmp_path)]).load("Scale.py").path == "Scale.py"
    closed = Search([str(tmp_path)], is_absolute_allowed=False)
    assert closed.read("inner.Scale").file == str(site / "inner/Scale.py")
    assert loader.unload("Scale") == str(site / "inner/Scale.py")


def test_load_paths_come_first(site, tmp_path):
    install(site, "[rtkit.components]\nScale = Scale:ScaleInit\n", ["Scale.py"])
    near = tmp_path / "near"
    near.mkdir()
    install(near, "", ["Scale.py"])
    assert Search([str(near)]).read("Scale.py").file == str(near / "Scale.py")
    assert list(Search([str(near)]).modules()).count("Scale.py") == 1
    assert Search([]).read("Scale.py").file == str(site / "Scale.py")


def test_they_are_listed_and_not_run(site, monkeypatch):
    install(site, "[rtkit.components]\nScale = Scale:ScaleInit\nmy = In:other\n", ["Scale.py"])
    (site / "In.py").write_text(CODE.format(name="In", init="other"))
    lines = loadable([]).splitlines()
    assert [line for line in lines if line.startswith("RTC:me::Scale:")]
    assert [line for line in lines if line.startswith("RTC:me::In:")]
    import os

    assert "RTKIT_TEST_RAN" not in os.environ


def test_what_strangers_may_write_is_refused(site):
    install(site, "[rtkit.components]\nScale = Scale:ScaleInit\n", ["Scale.py"])
    (site / "Scale.py").chmod(0o666)
    with pytest.raises(Refused, match="may be written by everybody"):
        Search([]).read("Scale")


def test_what_is_nowhere_is_told_so():
    with pytest.raises(NotFound, match=r"no module Nix .looked in /a and among installed packages"):
        Search(["/a"]).read("Nix")


def test_a_module_of_a_package_may_be_named_as_python_does(site):
    install(site, "", ["inner/deep/Arm.py"])
    source = Search([]).read("inner.deep.Arm")
    assert (source.file, source.init) == (str(site / "inner/deep/Arm.py"), "")
    assert [each.type_name for each in Loader([]).load("inner.deep.Arm", "ArmInit").types] == [
        "Arm"
    ]
    for name in ("inner.deep.Leg", "inner.none.Arm", "inner..Arm", "."):
        with pytest.raises(NotFound):
            Search([]).read(name)
    with pytest.raises(NotFound):
        Search([], is_absolute_allowed=False).read("inner.deep.Arm")


RELATIVE = """
from rtkit.component import Component
from .helpers import NAME
import {top}.helpers

class Arm{top}(Component):
    name = NAME

def ArmInit(manager):
    manager.register_factory(Arm{top})
"""


def package(folder, top, inits=("",)):
    """Write a package whose module imports a helper relatively; return the module's file."""
    (folder / top).mkdir(parents=True)
    for name in inits:
        (folder / top / f"{name or '__init__'}.py").write_text("")
    (folder / top / "helpers.py").write_text(f"NAME = '{top}'")
    file = folder / top / "Arm.py"
    file.write_text(RELATIVE.format(top=top))
    return file


@pytest.fixture
def clean():
    known = set(sys.modules)
    yield
    for name in set(sys.modules) - known:
        if name.startswith(("one", "two", "rtkit_module")):
            del sys.modules[name]


@pytest.mark.usefixtures("clean")
@pytest.mark.parametrize("inits", [["__init__"], []])
def test_packages_with_modules_of_equal_names_are_side_by_side(site, inits):
    loader = Loader([])
    for top in ("one", "two"):
        package(site, top, inits)
        loader.load(f"{top}.Arm", "ArmInit")
    made = [loader.make(parse_create(f"Arm{top}")).name for top in ("one", "two")]
    assert made == ["one", "two"]
    assert "helpers" not in sys.modules


@pytest.mark.usefixtures("clean")
def test_a_package_in_a_load_path_is_named_as_python_does(tmp_path):
    file = package(tmp_path / "folder", "one")
    loader = Loader([str(tmp_path / "folder")])
    assert loader.load("one.Arm", "ArmInit").file == str(file)
    closed = Search([str(tmp_path / "folder")], is_absolute_allowed=False)
    assert closed.read("one.Arm").package == "one"
    with pytest.raises(NotFound):
        closed.read("one.Nix")


@pytest.mark.usefixtures("clean")
def test_a_file_below_an_init_file_is_part_of_that_package(tmp_path):
    file = package(tmp_path, "one")
    loader = Loader([])
    loader.load(str(file), "ArmInit")
    assert loader.make(parse_create("Armone")).name == "one"


@pytest.mark.usefixtures("clean")
def test_helpers_of_a_package_are_its_code_and_imported_anew(site):
    file = package(site, "one")
    loader = Loader([])
    loader.load("one.Arm", "ArmInit")
    made = loader.make(parse_create("Armone"))
    code = [line.partition(" ")[2] for line in describe(made).code.splitlines()]
    assert set(code) == {str(file), *(str(site / "one" / n) for n in ("__init__.py", "helpers.py"))}
    (site / "one" / "helpers.py").write_text("NAME = 'another'")
    assert loader.changed(made.type) == "one.Arm"
    loader.unload("one.Arm")
    loader.load("one.Arm", "ArmInit")
    assert loader.make(parse_create("Armone")).name == "another"
