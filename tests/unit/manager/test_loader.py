"""Modules are found, checked, imported, forgotten; what goes wrong is told with its place."""

from __future__ import annotations

import os
import sys
import zlib
from types import ModuleType

import pytest

from rtkit.component.describe import describe
from rtkit.errors import NotFound, Refused
from rtkit.modules import loader as loader_module
from rtkit.modules.loader import Loader, UntriedModule
from rtkit.rtc.create import parse_create

THING = '''
from rtkit.component import Component

class Thing(Component):
    """{text}"""

def {name}Init(manager):
    manager.register_factory(Thing)
'''


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "Thing.py").write_text(THING.format(name="Thing", text="One"))
    return tmp_path


@pytest.fixture
def loader(folder, monkeypatch):
    monkeypatch.setattr(sys, "path", [each for each in sys.path if "-packages" not in each])
    return Loader([str(folder)])


def make(loader, text):
    return loader.make(parse_create(f"{text}?instance_name=A"))


TWO = """
from rtkit.component import Component

made = []

class A(Component): pass

class B(Component): pass

def AInit(manager):
    made.append(A)
    manager.register_factory(A)

def BInit(manager):
    made.append(B)
    manager.register_factory(B)
"""


def test_each_init_function_is_called_once_in_one_import(loader, folder):
    (folder / "Two.py").write_text(TWO)
    (folder / "link.py").symlink_to("Two.py")
    first, second = loader.load("Two.py", "AInit"), loader.load("Two", "BInit")
    assert [(each.path, each.init) for each in (first, second)] == [
        ("Two.py", "AInit"),
        ("Two", "BInit"),
    ]
    assert loader.load("link.py", "AInit") is loader.load(f"{folder}/Two.py", "AInit") is first
    made = sys.modules[type(make(loader, "B")).__module__].made
    assert [each.__name__ for each in made] == ["A", "B"]
    assert make(loader, "A").type.type_name == "A"
    with pytest.raises(NotFound, match="no init function CInit"):
        loader.load("Two.py", "CInit")
    assert loader.unload("link.py") == str(folder / "Two.py")
    for name in "AB":
        with pytest.raises(NotFound):
            make(loader, name)


NEAR = """
from rtkit.component import Component

class Base(Component):
    def on_exectue(self, context): pass
    def onActivated(self, context): pass

class Near(Base):
    def on_execute(self, context): pass
    def on_button(self): pass
    def once(self): pass
    on_resett = 3

def NearInit(manager):
    manager.register_factory(Near)
"""


def test_methods_that_look_like_callbacks_are_told(loader, folder):
    (folder / "Near.py").write_text(NEAR)
    assert sorted(loader.remarks(loader.load("Near.py"))) == [
        "Near.onActivated is no callback (did you mean on_activated?)",
        "Near.on_exectue is no callback (did you mean on_execute?)",
    ]
    assert loader.remarks(loader.load("Thing.py")) == []


def test_one_look_at_a_file_does_for_a_batch(loader, folder, monkeypatch):
    now_s = [0.0]
    monkeypatch.setattr(loader_module.time, "monotonic", lambda: now_s[0])
    component = make(loader, "Thing")
    assert [loader.changed(component.type) for _ in range(2)] == [""] * 2
    text = (folder / "Thing.py").read_text()
    (folder / "Thing.py").write_text(text.replace("One", "Another"))
    assert loader.changed(component.type) == ""
    now_s[0] += 0.02
    assert loader.changed(component.type) == "Thing.py"
    assert loader.changed(component.type) == "Thing.py"  # what has changed is told each time


def test_code_that_was_edited_is_told(loader, folder, monkeypatch):
    monkeypatch.setattr(loader_module, "_LOOK_S", 0.0)
    component = make(loader, "Thing")
    assert [each.path for each in loader.found()] == ["Thing.py"]
    assert (loader.found(), loader.changed(component.type)) == ([], "")
    text = (folder / "Thing.py").read_text()
    (folder / "Thing.py").write_text(text)
    assert loader.changed(component.type) == ""  # written, but as it was
    (folder / "Thing.py").write_text(text.replace("One", "Another"))
    assert loader.changed(component.type) == "Thing.py"
    with pytest.raises(Refused, match="has changed since it was loaded"):
        loader.load("Thing.py", "OtherInit")
    loader.unload("Thing.py")
    assert make(loader, "Thing").type.description == "Another"


@pytest.mark.parametrize("form", ["Thing", "Thing.py", "{folder}/Thing.py"])
def test_a_module_is_found_by_name_or_path(loader, folder, form):
    path = form.format(folder=folder)
    profile = loader.load(path)
    assert (profile.path, profile.init) == (path, "ThingInit")
    assert [each.type_name for each in profile.types] == ["Thing"]
    component = make(loader, "Thing")
    assert component.type.description == "One"
    crc, _, file = describe(component).code.partition(" ")
    assert crc == f"{zlib.crc32((folder / 'Thing.py').read_bytes()):08x}"
    assert file == str(folder / "Thing.py")


def test_what_no_other_process_has_imported_is_not_imported_by_a_manager(loader, folder):
    careful = Loader([str(folder)], imports_untried=False)
    for ask in (lambda: careful.load("Thing.py"), lambda: make(careful, "Thing")):
        with pytest.raises(UntriedModule) as untried:
            ask()
        assert (untried.value.path, untried.value.init) == ("Thing.py", "")
    loader.load("Thing.py")
    careful.tried = {"Thing.py": loader.fingerprint("Thing.py")}
    assert make(careful, "Thing").instance == "A"


def test_a_module_that_was_changed_since_it_was_tried_is_not_imported(loader, folder):
    loader.load("Thing.py")
    careful = Loader([str(folder)], imports_untried=False)
    careful.tried = {"Thing.py": loader.fingerprint("Thing.py")}
    (folder / "Thing.py").write_text(THING.format(name="Thing", text="Two"))
    with pytest.raises(UntriedModule):
        careful.load("Thing.py")


@pytest.mark.parametrize("second", ["5", "int", "1 / 0"])
def test_a_module_that_fails_half_way_leaves_no_type_behind(loader, folder, second):
    text = THING.format(name="Half", text="Half")
    (folder / "Half.py").write_text(f"{text}    manager.register_factory({second})\n")
    with pytest.raises(Refused):
        loader.load("Half.py")
    assert loader.factories.types == ()
    with pytest.raises(NotFound):
        make(loader, "Thing2")


def test_loading_again_changes_nothing(loader, folder):
    profile = loader.load("Thing.py")
    (folder / "Thing.py").write_text("broken(")
    assert loader.load("Thing.py") is profile


def test_a_type_that_nobody_offers_is_looked_for(loader):
    assert make(loader, "Thing").instance == "A"
    with pytest.raises(NotFound, match="Other is not known; there are: Thing"):
        make(loader, "Other")


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ("thing", " (did you mean Thing?)"),
        ("Thin", " (did you mean Thing?)"),
        ("GroupingComposit", " (did you mean GroupingComposite?)"),
        ("Nothingnes", "; there are: Thing"),
    ],
)
def test_what_could_be_meant_is_told(loader, folder, asked, told):
    (folder / "Thinx.py").write_text("no module of components")
    (folder / "Nothingness.py").write_text("def NothingnessInit(manager): broken(")
    with pytest.raises(NotFound) as caught:
        make(loader, asked)
    assert str(caught.value) == f"component type {asked} is not known{told}"


def test_many_types_are_told_in_short(loader, folder):
    for number in range(10):
        text = (folder / "Thing.py").read_text().replace("Thing", f"Z{number}")
        (folder / f"Z{number}.py").write_text(text)
    with pytest.raises(NotFound) as caught:
        make(loader, "Other")
    assert str(caught.value).endswith(" more (rtmgr -m lists them)")
    assert str(caught.value).count(",") == 4


def test_without_search_only_what_is_offered_is_told(loader, folder):
    loader.configure([str(folder)], is_absolute_allowed=True, is_search_allowed=False)
    with pytest.raises(NotFound) as caught:
        make(loader, "thing")
    assert "Thing" not in str(caught.value)


def test_a_name_leads_to_no_other_folder(folder):
    loader = Loader([str(folder / "below")])
    (folder / "below").mkdir()
    (folder / "below" / "Link.py").symlink_to(folder / "Thing.py")
    for name in ("../Thing", f"{folder}/Thing", "./../Thing"):
        with pytest.raises(NotFound):
            make(loader, name)
    for name in ("../Thing.py", "x/../../Thing", ".."):
        with pytest.raises(Refused, match="leaves the load paths"):
            loader.load(name)
    for name in ("Link.py", "Link"):
        with pytest.raises(Refused, match="is a link that leaves the load path"):
            loader.load(name)
    with pytest.raises(Refused, match="is a link that leaves"):
        make(loader, "Link")


def test_a_link_inside_a_load_path_is_followed(folder):
    (folder / "sub").mkdir()
    (folder / "sub" / "Real.py").write_text(THING.format(name="Alias", text="One"))
    (folder / "Alias.py").symlink_to("sub/Real.py")
    loader = Loader([str(folder)])
    assert loader.load("Alias").types
    assert loader.load("sub/Real.py", "AliasInit").types


def test_absolute_paths_where_they_are_not_allowed(folder, tmp_path_factory):
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    (elsewhere / "Thing.py").write_text(THING.format(name="Thing", text="One"))
    (folder / "Link.py").symlink_to(elsewhere / "Thing.py")
    loader = Loader([])
    loader.configure([str(folder)], is_absolute_allowed=False, is_search_allowed=True)
    assert loader.load(f"{folder}/Thing.py").types
    with pytest.raises(Refused, match="abs_path_allowed is NO"):
        loader.load(f"{elsewhere}/Thing.py")
    with pytest.raises(Refused, match="leaves the load path"):
        loader.load(f"{folder}/Link.py")
    with pytest.raises(Refused, match="abs_path_allowed is NO"):
        loader.load(f"{folder}/../{elsewhere.name}/Thing.py")


def test_without_search_a_type_has_to_be_loaded_first(loader, folder):
    loader.configure([str(folder)], is_absolute_allowed=True, is_search_allowed=False)
    with pytest.raises(NotFound):
        make(loader, "Thing")
    loader.load("Thing")
    assert make(loader, "Thing").instance == "A"


@pytest.mark.parametrize("name", ["random", "os", "json", "rtkit"])
def test_a_module_may_have_the_name_of_a_standard_one(folder, name):
    (folder / f"{name}.py").write_text("import random\n" + THING.format(name=name, text="One"))
    loader = Loader([str(folder)])
    assert loader.load(name).types
    module = __import__(name)
    assert not (module.__file__ or "").startswith(str(folder))
    assert str(folder) not in sys.path[: len(sys.path) - 1]


def test_a_module_may_import_what_lies_beside_it(loader, folder):
    (folder / "rtkit_test_beside.py").write_text("text = 'Two'")
    text = "from rtkit_test_beside import text\n" + THING.format(name="Near", text="One")
    (folder / "Near.py").write_text(text)
    assert loader.load("Near").types
    assert sys.modules.pop("rtkit_test_beside").text == "Two"


def test_forgetting_a_module_forgets_its_types(loader, folder):
    loader.load("Thing.py")
    loader.unload("Thing.py")
    assert loader.factories.types == ()
    (folder / "Thing.py").write_text(THING.format(name="Thing", text="Two"))
    loader.load("Thing.py")
    assert make(loader, "Thing").type.description == "Two"
    loader.unload("Never.py")


def test_forgetting_one_of_two_modules_of_a_type_keeps_the_type(loader, folder):
    (folder / "Again.py").write_text(THING.format(name="Again", text="One"))
    loader.load("Thing.py")
    loader.load("Again.py")
    loader.unload("Thing.py")
    assert make(loader, "Thing").instance == "A"
    loader.unload("Again.py")
    assert loader.factories.types == ()


@pytest.mark.parametrize(
    ("source", "why"),
    [
        ("import nonsuch", r"ModuleNotFoundError: .*Thing.py:1\)"),
        ("x = 1\n1/0", r"ZeroDivisionError: .*Thing.py:2\)"),
        ("x = 1\n\ndef (", r"SyntaxError: .*Thing.py:3\)"),
        ("raise SystemExit(3)", "SystemExit: 3"),
        ("raise KeyboardInterrupt", "KeyboardInterrupt"),
        ("x = '\0'", "null bytes"),
        (b"# coding: nonsense\n".decode(), "unknown encoding"),
    ],
)
def test_a_module_that_does_not_import(loader, folder, source, why):
    before = set(sys.modules)
    (folder / "Thing.py").write_text(source)
    with pytest.raises(Refused, match=why) as caught:
        loader.load("Thing.py")
    assert "\n" not in str(caught.value).replace("\\n", "")
    # That an extra may be lacking, or it is Python 2, is looked up by modules of rtkit's own.
    mine = ("", ".migrate", ".migrate.age_hint", ".migrate.python2")
    own = {"rtkit.extras", *(f"rtkit.openrtm{each}" for each in mine)}
    assert set(sys.modules) - before <= own
    (folder / "Thing.py").write_text(THING.format(name="Thing", text="One"))
    assert loader.load("Thing.py").types


@pytest.mark.parametrize(
    ("source", "error", "why"),
    [
        ("", NotFound, "no init function ThingInit in module Thing.py"),
        ("ThingInit = 5", NotFound, "no init function"),
        ("def ThingInit(m):\n  raise SystemExit", Refused, r"SystemExit \(Thing.py:2"),
        ("def ThingInit(): pass", Refused, "TypeError"),
        ("def ThingInit(m): m.register_factory(int)", Refused, "not a component class"),
    ],
)
def test_an_init_function_that_is_missing_or_fails(loader, folder, source, error, why):
    (folder / "Thing.py").write_text(source)
    with pytest.raises(error, match=why):
        loader.load("Thing.py")
    assert loader.factories.types == ()


def test_what_is_no_file(loader, folder):
    for path in ("No.py", "", "/", str(folder)):
        with pytest.raises(NotFound, match="no module"):
            loader.load(path)


def test_a_module_that_everybody_may_write(loader, folder):
    os.chmod(folder / "Thing.py", 0o666)
    with pytest.raises(Refused, match="may be written by everybody"):
        loader.load("Thing.py")
    os.chmod(folder / "Thing.py", 0o644)
    os.chmod(folder, 0o777)
    with pytest.raises(Refused, match=f"folder {folder} may be written by everybody"):
        loader.load("Thing.py")
    (folder / "safe").mkdir(mode=0o755)
    (folder / "safe" / "Thing.py").write_text(THING.format(name="Thing", text="One"))
    with pytest.raises(Refused, match=f"folder {folder} may be written by everybody"):
        loader.load("safe/Thing.py")
    os.chmod(folder, 0o1777)
    assert loader.load("Thing.py").types


@pytest.mark.skipif(os.getuid() != 0, reason="only root can give files away")
def test_where_everybody_may_write_the_owner_matters(loader, folder):
    os.chmod(folder, 0o1777)
    os.chown(folder / "Thing.py", 65534, 65534)
    with pytest.raises(Refused, match="belongs to another user"):
        loader.load("Thing.py")


def test_a_pipe_is_not_waited_for(loader, folder):
    os.mkfifo(folder / "Pipe.py")
    with pytest.raises(NotFound):
        loader.load("Pipe.py")


def test_a_file_that_is_swapped_while_it_is_opened(loader, folder, monkeypatch):
    (folder / "Evil.py").write_text("raise SystemExit('ran')")
    opening = os.open

    def swap(path, *arguments, **more):
        if str(path).endswith("Thing.py"):
            os.replace(folder / "Evil.py", folder / "Thing.py")
            os.chmod(folder / "Thing.py", 0o666)
        return opening(path, *arguments, **more)

    monkeypatch.setattr(os, "open", swap)
    with pytest.raises(Refused, match="may be written by everybody"):
        loader.load("Thing.py")


WITH_HELPER = """
from rtkit.component import Component
import helper

class {kind}(Component):
    name = helper.NAME

def FooInit(manager):
    manager.register_factory({kind})
"""


@pytest.fixture
def both(tmp_path):
    """Folders of two modules of one name, each with a helper of the same name."""
    for name in "ab":
        folder = tmp_path / name
        folder.mkdir()
        (folder / "Foo.py").write_text(WITH_HELPER.format(kind=f"Foo{name}"))
        (folder / "helper.py").write_text("from deeper import NAME")
        (folder / "deeper.py").write_text(f"NAME = '{name}'")
    yield tmp_path
    for name in ("helper", "deeper"):
        sys.modules.pop(name, None)


def test_modules_of_one_name_have_each_what_lies_beside_it(both):
    loader = Loader([])
    for name in "ab":
        loader.load(str(both / name / "Foo.py"))
    assert [make(loader, f"Foo{name}").name for name in "ab"] == ["a", "b"]
    known = sys.modules["helper"]
    loader.load(str(both / "a" / "Foo.py"))
    assert sys.modules["helper"] is known  # what is there stays there


@pytest.mark.parametrize("changed", ["helper.py", "deeper.py"])
def test_what_lies_beside_a_module_is_its_code_too(both, changed):
    loader = Loader([])
    path = str(both / "a" / "Foo.py")
    loader.load(path)
    made = make(loader, "Fooa")
    files = [line.partition(" ")[2] for line in describe(made).code.splitlines()]
    assert sorted(map(os.path.basename, files)) == ["Foo.py", "deeper.py", "helper.py"]
    assert all(os.path.dirname(file) == str(both / "a") for file in files)
    (both / "a" / changed).write_text("NAME = 'new'")
    assert loader.changed(made.type) == path
    loader.unload(path)
    loader.load(path)
    assert make(loader, "Fooa").name == "new"


def test_what_a_module_does_not_import_is_none_of_its_code(both):
    (both / "a" / "Bar.py").write_text(THING.format(name="Bar", text="x"))
    loader = Loader([])
    loader.load(str(both / "a" / "Foo.py"))
    loader.load(str(both / "a" / "Bar.py"))
    made = make(loader, "Thing")
    assert describe(made).code.splitlines()[1:] == []


class Witness(ModuleType):
    """A module that counts how often something asks it where it is from."""

    looks = 0

    def __getattribute__(self, name):
        if name == "__file__":
            Witness.looks += 1
        return super().__getattribute__(name)


def test_a_folder_s_first_module_is_loaded_without_a_look_at_those_from_before(both, monkeypatch):
    monkeypatch.setitem(sys.modules, "witness", Witness("witness"))  # a slave shares its memory
    monkeypatch.setattr(Witness, "looks", 0)
    loader = Loader([])
    loader.load(str(both / "a" / "Foo.py"))
    assert Witness.looks == 0
    assert make(loader, "Fooa").name == "a"


def test_what_lies_beside_is_known_when_an_import_removes_modules(both, monkeypatch):
    monkeypatch.setitem(sys.modules, "witness", Witness("witness"))  # the last one that is there
    (both / "a" / "deeper.py").write_text("import sys\ndel sys.modules['witness']\nNAME = 'a'")
    loader = Loader([])
    loader.load(str(both / "a" / "Foo.py"))
    files = [line.partition(" ")[2] for line in describe(make(loader, "Fooa")).code.splitlines()]
    assert sorted(map(os.path.basename, files)) == ["Foo.py", "deeper.py", "helper.py"]
