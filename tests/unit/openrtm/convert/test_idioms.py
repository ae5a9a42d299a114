"""Conversion of old components into native ones, idiom by idiom."""

from __future__ import annotations

import textwrap
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import jsonrecords
import pytest

from rtkit.cli.shared import terminal
from rtkit.cli.shared.commands import load
from rtkit.component import Component, InPort, OutPort, TimedLong
from rtkit.errors import Refused
from rtkit.openrtm.convert.conversion import Conversion, convert

HEAD = """
import sys
import OpenRTM_aist
import RTC

spec = ["implementation_id", "Old", "type_name", "Old", "description", "An old one",
        "version", "1.2", "vendor", "Me", "category", "test", {extra} ""]

class Old(OpenRTM_aist.DataFlowComponentBase):
    def __init__(self, manager):
        OpenRTM_aist.DataFlowComponentBase.__init__(self, manager)
{setup}
        return

    def onInitialize(self):
        self.addInPort("in", self._inIn)
        self.addOutPort("out", self._outOut)
{prepare}
        return RTC.RTC_OK
{methods}

def OldInit(manager):
    profile = OpenRTM_aist.Properties(defaults_str=spec)
    manager.registerFactory(profile, Old, OpenRTM_aist.Delete)

def MyModuleInit(manager):
    OldInit(manager)
    comp = manager.createComponent("Old")

def main():
    mgr = OpenRTM_aist.Manager.init(sys.argv)
    mgr.setModuleInitProc(MyModuleInit)
    mgr.activateManager()
    mgr.runManager()

if __name__ == "__main__":
    main()
"""


def old(
    execute: str = "",
    *,
    data: str = "TimedLong(RTC.Time(0, 0), 0)",
    out: str = "TimedLong(RTC.Time(0, 0), 0)",
    setup: str = "",
    prepare: str = "",
    methods: str = "",
    extra: str = "",
) -> str:
    """Return an old component with these lines in its methods."""
    ports = f"""
self._d_in = RTC.{data}
self._inIn = OpenRTM_aist.InPort("in", self._d_in)
self._d_out = RTC.{out}
self._outOut = OpenRTM_aist.OutPort("out", self._d_out)
"""
    body = f"\n    def onExecute(self, ec_id):\n{_lines(execute, 8)}\n        return RTC.RTC_OK\n"
    return HEAD.format(
        setup=_lines(ports, 8) + "\n" + _lines(setup, 8),
        prepare=_lines(prepare, 8),
        methods=(body if execute else "") + _lines(methods, 4),
        extra=extra,
    )


def _lines(text: str, indent: int) -> str:
    return textwrap.indent(textwrap.dedent(text).strip("\n"), " " * indent)


def converted(source: str) -> Conversion:
    """Return a conversion that needs no hand."""
    made = convert(source.encode(), "Old.py")
    assert made.marks == (), made.text
    return made


def reasons(source: str) -> list[str]:
    """Return why a source needs a hand; each reason stands in the text at its place too."""
    made = convert(source.encode(), "Old.py")
    for mark in made.marks:
        assert f"# rtkit convert: {mark.reason}" in made.text
    return [each.reason for each in made.marks]


def component_of(source: str) -> Any:
    """Return an instance of the converted component, prepared as a container does it."""
    registered: list[type[Component]] = []
    module: dict[str, Any] = {"__name__": "converted"}
    exec(compile(converted(source).text, "converted.py", "exec"), module)
    module["OldInit"](SimpleNamespace(register_factory=registered.append))
    component = registered[0]("Old0")
    component.on_initialize()
    return component


def written(component: Any, *values: Any) -> list[Any]:
    """Return what an execution writes for each value that comes, without its time."""
    from rtkit.rtc.profiles import ConnectorProfile

    sent: list[Any] = []
    sink = component.ports["in"].open(ConnectorProfile("one", "one", (), {}))
    component.ports["out"].attach("two", sent.append)
    for value in values or (None,):
        if value is not None:
            sink(value)
        component.on_execute("0")
    return [getattr(each, "data", each) for each in sent]


def test_identity_ports_and_init_function() -> None:
    component = component_of(old("pass"))
    profile = component.type_profile()
    assert (profile.type_name, profile.description) == ("Old", "An old one")
    assert (profile.vendor, profile.category, profile.version) == ("Me", "test", "1.2")
    assert isinstance(component.in_, InPort)
    assert component.in_.name == "in"
    assert isinstance(component.out, OutPort)
    assert component.out.data_type is TimedLong


def test_a_value_filled_right_before_its_write_is_built_there() -> None:
    source = old("self._d_out.data = 2 * self._inIn.read().data\nself._outOut.write()")
    text = converted(source).text
    assert (
        "self.out.write(TimedLong(Time.now(), 2 * (self.in_.read() or TimedLong()).data))" in text
    )
    assert "on_initialize" not in text
    assert written(component_of(source), TimedLong(data=3)) == [6]


def test_reading_behind_a_question_needs_no_default() -> None:
    source = old(
        """
        if self._inIn.isNew():
            data = self._inIn.read()
            self._d_out.data = data.data + 1
            OpenRTM_aist.setTimestamp(self._d_out)
            self._outOut.write()
        """
    )
    text = converted(source).text
    assert "data = self.in_.read()\n" in text
    assert "setTimestamp" not in text
    assert written(component_of(source), TimedLong(data=3)) == [4]


def test_a_value_filled_step_by_step_is_a_variable() -> None:
    source = old(
        """
        self._d_out.data = []
        for i in range(3):
            self._d_out.data.append(i)
        self._outOut.write()
        """,
        out="TimedLongSeq(RTC.Time(0, 0), [])",
    )
    assert "out = []" in converted(source).text
    assert written(component_of(source)) == [(0, 1, 2)]


def test_a_value_that_grows_from_call_to_call_is_an_attribute() -> None:
    source = old(
        "self._d_out.data.append(len(self._d_out.data))\nself._outOut.write()",
        out="TimedLongSeq(RTC.Time(0, 0), [])",
    )
    component = component_of(source)
    assert written(component, TimedLong(), TimedLong()) == [(0,), (0, 1)]


def test_fields_of_a_structure_are_kept_one_by_one() -> None:
    source = old(
        """
        self._d_out.data.position.x += 1
        self._d_out.data.heading = self._d_out.data.position.x / 2
        self._outOut.write()
        """,
        out="TimedPose2D(RTC.Time(0, 0), RTC.Pose2D(RTC.Point2D(1.0, 5.0), 0.0))",
    )
    sent = written(component_of(source), TimedLong(), TimedLong())
    assert [(each.position.x, each.position.y, each.heading) for each in sent] == [
        (2.0, 5.0, 1.0),
        (3.0, 5.0, 1.5),
    ]


def test_parts_are_kept_in_the_order_of_their_fields() -> None:
    text = converted(
        old(
            """
            self._d_out.data.heading += 1
            self._d_out.data.position.y += 1
            self._d_out.data.position.x += 1
            self._outOut.write()
            """,
            out="TimedPose2D(RTC.Time(0, 0), RTC.Pose2D(RTC.Point2D(1.0, 5.0), 0.0))",
        )
    ).text
    head = text[text.index("def on_initialize") : text.index("def on_execute")]
    lines = ["self._x = 1.0", "self._y = 5.0", "self._heading = 0.0"]
    assert [line.strip() for line in head.splitlines()[1:] if line.strip()] == lines


def test_a_structure_used_as_a_whole_is_replaced() -> None:
    source = old(
        """
        self._d_out.data = RTC.Point2D(1.0, 2.0)
        self._d_out.data.x = 7.0
        self._outOut.write()
        """,
        out="TimedPoint2D(RTC.Time(0, 0), RTC.Point2D(0.0, 0.0))",
    )
    assert "replace(" in converted(source).text
    assert [(p.x, p.y) for p in written(component_of(source))] == [(7.0, 2.0)]


def test_fields_of_received_values_are_replaced() -> None:
    source = old(
        """
        if self._inIn.isNew():
            data = self._inIn.read()
            data.data.x = -data.data.x
            data.data.y += 1
            self._outOut.write(data)
        """,
        data="TimedPoint2D(RTC.Time(0, 0), RTC.Point2D(0.0, 0.0))",
        out="TimedPoint2D(RTC.Time(0, 0), RTC.Point2D(0.0, 0.0))",
    )
    from rtkit.component import Point2D, TimedPoint2D

    sent = written(component_of(source), TimedPoint2D(data=Point2D(1.0, 2.0)))
    assert [(p.x, p.y) for p in sent] == [(-1.0, 3.0)]


def test_a_received_sequence_that_is_kept_or_changed_becomes_a_list() -> None:
    source = old(
        """
        if self._inIn.isNew():
            self._d_in = self._inIn.read()
            kept = self._d_in.data
            kept.append(len(self._d_in.data))
            self.last = self._d_in.data[:]
            self.last.append(9)
            self._d_out.data = kept + self.last
            self._outOut.write()
        """,
        data="TimedLongSeq(RTC.Time(0, 0), [])",
        out="TimedLongSeq(RTC.Time(0, 0), [])",
    )
    from rtkit.component import TimedLongSeq

    component = component_of(source)
    assert written(component, TimedLongSeq(data=(4, 5))) == [(4, 5, 2, 4, 5, 9)]


def test_time_stamps_that_a_component_sets_are_kept() -> None:
    source = old(
        """
        data = self._inIn.read()
        self._d_out.tm = RTC.Time(data.tm.sec, 5)
        self._d_out.data = data.data
        self._outOut.write()
        """
    )
    from rtkit.component import Time

    component = component_of(source)
    sent: list[Any] = []
    component.out.attach("two", sent.append)
    component.on_execute("0")
    assert sent == [TimedLong(Time(0, 5), 0)]


def test_values_that_no_port_is_bound_to() -> None:
    source = old(
        """
        value = RTC.TimedLong(RTC.Time(0, 0), 0)
        value.data = 5
        OpenRTM_aist.setTimestamp(value)
        self._outOut.write(value)
        """
    )
    assert written(component_of(source)) == [5]


PARAMETERS = {
    "number": ("[3]", '"4"', 4),
    "size": ("[0.5]", '"0.25"', 0.25),
    "word": ('["a"]', '"b"', "b"),
    "gains": ("[[1.0, 2.0]]", '"3, 4.5"', (3.0, 4.5)),
    "steps": ("[[1, 2]]", '"3,4,5"', (3, 4, 5)),
    "wrong": ("[7]", '"none"', 7),
}


@pytest.mark.parametrize("name", PARAMETERS)
def test_parameters_have_the_value_of_their_text(name: str) -> None:
    first, text, value = PARAMETERS[name]
    source = old(
        "self._d_out.data = 1\nself._outOut.write()",
        setup=f"self._p = {first}",
        prepare=f'self.bindParameter("{name}", self._p, {text})',
    )
    component = component_of(source)
    assert getattr(component, name) == value
    assert component.configuration.sets["default"][name]


def test_a_list_of_texts_is_one_text() -> None:
    source = old(
        "self._d_out.data = self._p[0].index('b')\nself._outOut.write()",
        setup='self._p = [["a"]]',
        prepare='self.bindParameter("p", self._p, "a, b")',
    )
    component = component_of(source)
    assert component.p == "a, b"
    assert written(component) == [1]


def test_what_is_read_and_never_looked_at_is_read_still() -> None:
    text = converted(old("self._d_in = self._inIn.read()")).text
    assert "        self.in_.read()\n" in text


def test_the_specification_gives_values_sets_widgets_and_constraints() -> None:
    extra = (
        '"conf.default.gain", "2.5", "conf.fast.gain", "9.0", "conf.__widget__.gain", "text", '
        '"conf.__constraints__.gain", "0.0<=x<=10.0", "conf.default.free", "x y", '
    )
    source = old(
        "self._d_out.data = int(self._gain[0])\nself._outOut.write()",
        setup="self._gain = [1.0]",
        prepare='self.bindParameter("gain", self._gain, "1.0")',
        extra=extra,
    )
    component = component_of(source)
    assert component.gain == 2.5
    assert component.free == "x y"
    assert component.configuration.sets["fast"]["gain"] == "9.0"
    assert component.configuration.sets["__constraints__"]["gain"] == "0.0<=x<=10.0"
    assert written(component) == [2]


def test_texts_of_rtc_builder_become_documentation() -> None:
    setup = '''
    """
    How far it may go
     - Name: reach reach
     - DefaultValue: 3
     - Unit: mm
    """
    self._reach = [3]
    '''
    source = old("pass", setup=setup, prepare='self.bindParameter("reach", self._reach, "3")')
    assert 'reach = Parameter(3, doc="How far it may go", unit="mm")' in converted(source).text


def test_return_codes() -> None:
    methods = """
    def onActivated(self, ec_id):
        if self.fails():
            return RTC.RTC_ERROR
        return RTC.RTC_OK

    def onDeactivated(self, ec_id):
        print("down")
        return RTC.RTC_OK

    def fails(self):
        return True
    """
    source = old("pass", methods=methods)
    text = converted(source).text
    assert "def on_activated(self, context: str) -> ReturnCode:" in text
    assert 'def on_deactivated(self, context: str) -> None:\n        print("down")\n\n' in text
    from rtkit.component import ReturnCode

    assert component_of(source).on_activated("0") is ReturnCode.ERROR


def test_names_that_every_component_has_are_given_way() -> None:
    source = old(
        "self.type = 5\nself._d_out.data = self.type\nself.reset()\nself._outOut.write()",
        methods="\ndef reset(self):\n    self.report = 1\n",
    )
    assert written(component_of(source)) == [5]


def test_what_a_constructor_sets_is_set_before_what_initialize_does() -> None:
    source = old(
        "self._d_out.data = self.sum\nself._outOut.write()",
        setup="self.sum = 1  # from here",
        prepare="self.sum += 1  # to there",
    )
    text = converted(source).text
    assert text.index("# from here") < text.index("# to there")
    assert "__init__" not in text
    assert written(component_of(source)) == [2]


def test_comments_and_layout_of_the_author_stay() -> None:
    source = old(
        "value = ( 1+\n    2 )  # odd,  but mine\nself._d_out.data = value\nself._outOut.write()"
    )
    text = converted(source).text
    assert "value = ( 1+\n            2 )  # odd,  but mine" in text


def test_comments_of_generators_go() -> None:
    methods = """
    ##
    # The deactivated action (Active state exit action)
    # former rtc_active_exit()
    # it is important
    # @param ec_id target ExecutionContext Id
    # @return RTC::ReturnCode_t
    #
    def onDeactivated(self, ec_id):
        print(1)
        return RTC.RTC_OK

    #def onError(self, ec_id):
    #
    #	return RTC.RTC_OK
    """
    text = converted(old("pass", methods=methods)).text
    assert "# it is important" in text
    assert "former" not in text
    assert "onError" not in text
    assert "RTC_OK" not in text


def test_imports_are_those_that_are_used() -> None:
    text = converted(
        "import os, math\n" + old("self._d_out.data = int(math.pi)\nself._outOut.write()")
    ).text
    assert "import math\n" in text
    assert not {"import os", "import sys", "OpenRTM", "import RTC"} & set(text.splitlines())


def test_names_of_a_star_import() -> None:
    source = old("self._d_out.data = 4\nself._outOut.write()").replace("OpenRTM_aist.", "")
    source = source.replace("import OpenRTM_aist\n", "from OpenRTM_aist import *\n")
    assert written(component_of(source)) == [4]


def test_functions_beside_a_component_make_and_change_values() -> None:
    source = old("self._outOut.write(made(3))").replace(
        "class Old(",
        "def made(number):\n"
        "    value = RTC.TimedLong(RTC.Time(0, 0), 1)\n"
        "    value.data += number\n"
        "    OpenRTM_aist.setTimestamp(value)\n"
        "    return value\n\n\nclass Old(",
    )
    assert written(component_of(source)) == [4]


def test_octets_are_bytes() -> None:
    source = old(
        "self._outOut.write()\nself._d_out.data = b'ab'",
        out="TimedOctetSeq(RTC.Time(0, 0), [])",
    )
    assert written(component_of(source), TimedLong(), TimedLong()) == [b"", b"ab"]


def test_logger() -> None:
    text = converted(old('self._rtcout.RTC_INFO("at %d of %d", (1, 2))')).text
    assert 'self.logger.info("at %d of %d", 1, 2)' in text


def test_a_component_that_activates_itself_still_does() -> None:
    source = old("pass").replace(
        'comp = manager.createComponent("Old")',
        'comp = manager.createComponent("Old")\n'
        "    ecs = comp.get_owned_contexts()\n    ecs[0].activate_component(comp)",
    )
    assert "rtkit.run(Old, activate=True)" in converted(source).text


def test_the_init_function_has_a_name_of_its_own() -> None:
    source = old("pass").replace("def OldInit(manager):", "def MyModuleInit(manager):", 1)
    source = source.replace("def MyModuleInit(manager):\n    OldInit(manager)\n    comp", "comp")
    source = source.replace('comp = manager.createComponent("Old")\n', "")
    assert "def OldInit(manager: Manager) -> None:" in converted(source).text


NEED_A_HAND = {
    "heir": (old("pass") + "\nclass Heir(Old):\n    pass\n", "derives from a component"),
    "service port": (
        old("pass", setup='self._p = OpenRTM_aist.CorbaPort("p")', prepare="self.addPort(self._p)"),
        "a service port",
    ),
    "listener": (
        old("pass", prepare="self._inIn.addConnectorDataListener(1, None)"),
        "a listener of a connector",
    ),
    "parameter is set": (
        old(
            "self._p[0] = 4",
            setup="self._p = [1]",
            prepare='self.bindParameter("p", self._p, "1")',
        ),
        "a parameter is changed in configuration sets only",
    ),
    "parameter is replaced": (
        old(
            "self._p = [['c']]",
            setup='self._p = [["a"]]',
            prepare='self.bindParameter("p", self._p, "a,b")',
        ),
        "a parameter is changed in configuration sets only",
    ),
    "rebound": (
        old("self._d_out = RTC.TimedLong(RTC.Time(0, 0), 3)\nself._outOut.write()"),
        "write() sends the value that the port was made with",
    ),
    "given away": (old("self.fill(self._d_out)\nself._outOut.write()"), "could change it"),
    "second name": (
        old(
            "data = self._inIn.read()\npoint = data.data\npoint.x = 2\nprint(data)",
            data="TimedPoint2D(RTC.Time(0, 0), RTC.Point2D(0.0, 0.0))",
        ),
        "second name",
    ),
    "received in place": (
        old(
            "data = self._inIn.read()\ndata.data.append(3)\nprint(data)",
            data="TimedLongSeq(RTC.Time(0, 0), [])",
        ),
        "received value is changed in place",
    ),
    "item of a list": (
        old("for each in self.points:\n    each.x = 1\nself.points = [RTC.Point2D(0, 0)]"),
        "may change a value of a data type",
    ),
    "context": (old("print(ec_id + 1)"), "the id of a context is a text"),
    "context object": (old("self.get_owned_contexts()[0].set_rate(3)"), "get_owned_contexts"),
    "manager": (old("OpenRTM_aist.Manager.instance().shutdown()"), "the manager of OpenRTM"),
    "result of a write": (
        old("self._d_out.data = 1\nif self._outOut.write():\n    pass"),
        "write() returns a PortStatus",
    ),
    "conditional port": (
        old("pass", prepare='if True:\n    self._x = OpenRTM_aist.InPort("x", self._d_in)'),
        "under a condition",
    ),
    "lists": (
        old("pass", setup="self._p = [[[1]]]", prepare='self.bindParameter("p", self._p, "1")'),
        "list of what no parameter can have",
    ),
}


@pytest.mark.parametrize("case", NEED_A_HAND)
def test_what_needs_a_hand_is_marked_with_its_reason(case: str) -> None:
    source, reason = NEED_A_HAND[case]
    assert any(reason in each for each in reasons(source)), reasons(source)


def test_a_mark_has_the_line_of_the_old_source() -> None:
    source = old("OpenRTM_aist.Manager.instance().shutdown()")
    (mark,) = convert(source.encode(), "Old.py").marks
    assert "Manager.instance()" in source.splitlines()[mark.line - 1]


def test_a_source_without_component_is_refused() -> None:
    with pytest.raises(Refused, match="has no component"):
        convert(b"import OpenRTM_aist\n", "plain.py")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a component that is clean, and one that needs a hand."""
    clean = old("self._d_out.data = 1\nself._outOut.write()")
    (tmp_path / "Old.py").write_text(clean, encoding="utf-8")
    by_hand = old("OpenRTM_aist.Manager.instance().shutdown()")
    (tmp_path / "Hard.py").write_text(by_hand, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_command_writes_to_stdout_or_to_a_file(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = load("rtopenrtm")
    assert run(["convert", "Old.py"]) == 0
    text = capsys.readouterr().out
    assert text == converted((folder / "Old.py").read_text(encoding="utf-8")).text
    assert run(["convert", "Old.py", "-o", "New.py"]) == 0
    assert (folder / "New.py").read_text(encoding="utf-8") == text
    assert run(["convert", "--diff", "Old.py"]) == 0
    assert "-class Old(OpenRTM_aist.DataFlowComponentBase):\n" in capsys.readouterr().out


def test_what_is_piped_is_the_file_with_its_tabs(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    run = load("rtopenrtm")
    source = (folder / "Old.py").read_text(encoding="utf-8")
    remarked = source.replace("import sys", "import sys\n\nN = 1\t# of \x1b[2Jtabs\f", 1)
    (folder / "Old.py").write_text(remarked, encoding="utf-8")
    assert run(["convert", "Old.py"]) == 0
    assert capsys.readouterr().out == converted(remarked).text
    assert "N = 1\t# of \x1b[2Jtabs" in converted(remarked).text
    monkeypatch.setattr(terminal, "is_terminal", lambda: True)
    assert run(["convert", "Old.py"]) == 0
    assert "N = 1\t# of \\x1b[2Jtabs" in capsys.readouterr().out


def test_the_command_takes_no_place_unasked(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = load("rtopenrtm")
    (folder / "New.py").write_text("mine", encoding="utf-8")
    assert run(["convert", "Old.py", "-o", "New.py"]) == 1
    assert "New.py is there already (--force writes it anew)" in capsys.readouterr().err
    assert (folder / "New.py").read_text(encoding="utf-8") == "mine"
    assert run(["convert", "--force", "Old.py", "-o", "New.py"]) == 0
    assert run(["convert", "--force", "Old.py", "-o", "Old.py"]) == 1
    assert "Old.py is the old component" in capsys.readouterr().err


def test_the_command_tells_what_needs_a_hand(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = load("rtopenrtm")
    assert run(["convert", "--json", "Hard.py", "-o", "New.py"]) == 1
    told = capsys.readouterr()
    (record,) = jsonrecords.checked(told.out)
    assert jsonrecords.kind_of(record) == "converted-component"
    (mark,) = record["marks"]
    assert (record["output"], record["ports"], record["components"]) == ("New.py", 2, ["Old"])
    assert f"Hard.py:{mark['line']}: {mark['reason']}\n" in told.err
    assert "# rtkit convert: the manager of OpenRTM" in (folder / "New.py").read_text()


def test_the_command_names_what_it_cannot_convert(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = load("rtopenrtm")
    (folder / "plain.py").write_text("x = 1\n", encoding="utf-8")
    for arguments, why in (
        (["Nothing.py"], "Nothing.py: No such file or directory"),
        (["plain.py"], "plain.py has no component"),
        (["Old.py", "Hard.py"], "takes one file"),
        (["Old.py", "-o", "no/New.py"], "no/New.py"),
    ):
        assert run(["convert", *arguments]) == 1
        assert why in capsys.readouterr().err
