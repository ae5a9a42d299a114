"""Interface definitions as Python: what they look like, and that rtkit carries them."""

from __future__ import annotations

import sys
from types import ModuleType

import pytest

from rtkit.builder.component_files import build_types
from rtkit.builder.obstacles import of_interface
from rtkit.builder.standard_types import KNOWN
from rtkit.builder.types_code import TypesCode
from rtkit.component.services.interface import Interface
from rtkit.component.services.interface_definition import definition_of
from rtkit.component.values.codec import codec_for
from rtkit.component.values.type_layout import layout_of
from rtkit.component.values.typenames import type_by_name, type_name
from rtkit.idl.read import read_idl
from rtkit.rtc.profiles import operations_in


@pytest.fixture
def load(monkeypatch):
    """Return what makes a module of IDL text."""

    def made(definitions, *names):
        wanted = [tuple(name.split("::")) for name in names] or list(definitions.by_path)
        text = TypesCode(definitions, wanted).text(["x.idl"])
        module = ModuleType("made_idl")
        monkeypatch.setitem(sys.modules, "made_idl", module)
        exec(compile(text, "made_idl.py", "exec"), module.__dict__)
        module.text = text
        return module

    return made


def read(text):
    return read_idl(text, "a.idl", known=KNOWN)


def test_a_service(load, builder):
    module = load(builder.idl("MyService.idl"), "SimpleService::MyService")
    assert list(Interface(module.MyService).by_signature) == [
        "echo(msg:string)->string",
        "get_echo_history()->sequence<string>",
        "set_value(value:float32)->void",
        "get_value()->float32",
        "get_value_history()->sequence<float32>",
    ]
    assert module.MyService.__doc__.startswith("Interface MyService.\n\n    Echoes texts")
    assert module.MyService.echo.__doc__ == "Return the text."


def test_only_what_is_needed_is_there(load, builder):
    module = load(builder.idl("Arm.idl"), "Robot::Arm::Point")
    assert [name for name in vars(module) if name[0].isupper()] == ["Point"]
    module = load(builder.idl("Arm.idl"), "Robot::Arm::Base")
    assert {"Base", "Mode", "Result", "MAX_POINTS", "FIRST"} < set(vars(module))
    assert not {"Status", "Common", "Refused"} & set(vars(module))


def test_structures_are_carried_with_every_kind_of_member(load, builder):
    module = load(builder.idl("Arm.idl"), "Robot::Arm::Common")
    value = module.Status(
        name="a",
        mode_=module.Mode.FAULT,
        angles=(1.0,) * 6,
        pose=((0.5,) * 4,) * 3,
        path=(module.Point(1.0, 2.0, 3.0), module.Point()),
        picture=b"\x00\xff",
        raw=b"raw",
        last=module.Result(7, "x"),
        codes=(1, 65535),
        samples=tuple(range(40)),
        is_on=True,
        unit="m",
        remark="日本",
        count=2**63,
    )
    codec = codec_for(module.Status)
    assert codec.decode(codec.encode(value)) == value
    assert codec.decode(codec.encode(module.Status())) == module.Status()
    kinds = {name: kind.name for name, kind in layout_of(module.Status).fields}
    assert kinds["angles"] == "array of 6"
    assert kinds["samples"] == "array of 40"
    assert kinds["picture"] == kinds["raw"] == "sequence<octet>"
    assert kinds["path"] == "sequence<Point>"
    assert type_name(module.Point) == "IDL:Robot/Arm/Point:1.0"
    assert type_by_name("Robot::Arm::Status") is module.Status


def test_operations_return_what_goes_out(load, builder):
    module = load(builder.idl("Arm.idl"), "Robot::Arm::Common")
    methods = Interface(module.Common).methods
    assert list(methods) == [
        *("clearAlarms", "get_mode_now", "get_speed", "set_speed"),
        *("getStatus", "moveTo", "both", "plan", "stop"),
    ]
    move = methods["moveTo"]
    point = module.Point(1.0)
    sent = move.encode_arguments((point, point, 3), {})
    assert move.decode_arguments(sent) == (point, point, 3)
    answer = (module.Result(1, "b"), 4)
    assert move.decode_result(move.encode_result(answer)) == answer
    assert "ticket: rt.Long) -> tuple[Result, rt.Long]:" in module.text
    assert "            The result and ``ticket``." in module.text
    assert "            Busy: As the interface definition says." in module.text


def test_constants_enumerations_and_exceptions(load, builder):
    module = load(builder.idl("Arm.idl"), "Robot::Arm::Common")
    assert (module.MAX_POINTS, module.HOME, module.IS_REAL) == (15, -0.5, False)
    assert module.GREETING == 'hello "arm"\n'
    assert module.FIRST is module.Mode.MOVING
    failure = module.Refused("why", 3)
    assert (failure.reason, failure.code, str(failure)) == ("why", 3, "('why', 3)")
    assert issubclass(module.Busy, Exception)


def test_what_an_operation_raises_arrives_as_itself_also_when_it_is_declared_inside(load):
    text = (
        "interface I { exception Odd { string why; long code; }; exception Plain {};"
        " void f() raises (Odd, Plain); };"
    )
    module = load(read(text))
    method = Interface(module.I).methods["f"]
    found = method.decode_exception(*method.encode_exception(module.Odd("why", 3)))
    assert (type(found), found.why, found.code) == (module.Odd, "why", 3)
    assert type(method.decode_exception(*method.encode_exception(module.Plain()))) is module.Plain
    assert "    @rt.raises(Odd, Plain)\n    def f(self) -> None:" in module.text


TWO = (
    "module M { enum Mode { IDLE, %s }; struct Pose { double x; }; typedef sequence<Pose> Poses;"
    " struct Way { Mode mode; Poses poses; }; exception Lost { Mode mode; };"
    " interface I { Way go() raises (Lost); }; };"
)


def test_modules_of_one_interface_definition_share_its_types(load):
    one, other = load(read(TWO % "DRIVING")), load(read("// again\n" + TWO % "DRIVING"))
    assert one.I is not other.I
    for name in ("Mode", "Pose", "Way", "Lost"):
        assert getattr(one, name) is getattr(other, name)
    assert type_by_name("IDL:M/Way:1.0") is one.Way
    way = other.Way(other.Mode.DRIVING, (one.Pose(1.0),))
    assert codec_for(one.Way).decode(codec_for(other.Way).encode(way)).mode is one.Mode.DRIVING


def test_a_type_that_changed_is_another_and_so_is_what_has_it_inside(load):
    one, other = load(read(TWO % "DRIVING")), load(read(TWO % "PARKED"))
    assert [getattr(one, n) is getattr(other, n) for n in ("Mode", "Pose", "Way", "Lost")] == [
        *(False, True, False, False)
    ]
    assert one.Way().mode is one.Mode.IDLE
    assert other.Way().mode is other.Mode.IDLE


def test_names_that_python_keeps_for_itself(load):
    module = load(
        read(
            "module M { struct class { long from; long l; string str; }; enum E { None, mro, A };"
            " interface I { void import(in long self, in long in, in class def); };"
            " struct tuple { class c; E e; }; };"
        )
    )
    assert module.class_(1, 2, "a").from_ == 1
    assert module.E.None_.value == 0
    assert list(Interface(module.I).methods) == ["import_"]
    codec = codec_for(module.Mtuple)
    assert codec.decode(codec.encode(module.Mtuple())) == module.Mtuple()


def test_equal_names_in_two_modules(load):
    module = load(
        read(
            "module A { struct S { long a; }; }; module B { struct S { A::S b; }; };"
            " interface I { B::S f(in A::S a); };"
        )
    )
    assert module.BS().b == module.S()
    assert type_name(module.BS) == "IDL:B/S:1.0"


def test_types_of_the_standard_are_those_of_rtkit(load):
    module = load(
        read("struct S { RTC::TimedLong a; RTC::GPSFixType b; Img::TimedCameraImage c; int8 d; };")
    )
    from rtkit.component import TimedLong

    assert module.S().a == TimedLong()
    codec = codec_for(module.S)
    assert codec.decode(codec.encode(module.S(d=-3))) == module.S(d=-3)


def test_arrays_of_structures(load):
    module = load(
        read("struct P { long x; }; struct S { P few[2]; P many[3][4]; sequence<P> s[9]; };")
    )
    value = module.S()
    assert value.many == ((module.P(),) * 4,) * 3
    assert value.s == ((),) * 9
    codec = codec_for(module.S)
    assert codec.decode(codec.encode(value)) == value


def test_long_results_have_a_name(load):
    text = "struct AnswerWithALongName { long n; }; interface I { AnswerWithALongName get("
    text += "out AnswerWithALongName a, out AnswerWithALongName b, out AnswerWithALongName c); };"
    module = load(read(text))
    assert "IgetResult = tuple[\n    AnswerWithALongName,\n" in module.text
    method = Interface(module.I).methods["get"]
    answer = tuple(module.AnswerWithALongName(n) for n in range(4))
    assert method.decode_result(method.encode_result(answer)) == answer


def test_out_parameters_are_told_again_by_a_port(load):
    operations = [
        "boolean measure(in long number, out double width, out string note)",
        "void both(out long left, out long right)",
        "void only(out string name)",
        "long plain(in string text)",
    ]
    module = load(read(f"interface I {{ {''.join(f'{each};' for each in operations)} }};"))
    assert '    @rt.returns("", "width", "note")\n    def measure(' in module.text
    told = operations_in(definition_of([Interface(module.I)]))
    assert [text for _, text in told] == operations


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("interface I { any get(); };", "operation get: any has no form in CDR here"),
        ("interface I { I get(); };", "operation get: I is an interface, to which no reference"),
        ("interface I { attribute Object o; };", "attribute o: Object has no form in CDR here"),
        ("interface J {}; interface I : J {};", "it has no operations"),
        ("struct T; struct T { sequence<T> k; }; interface I { T f(); };", "T contains itself"),
        ("union U switch (long) { case 1: long n; }; interface I { U f(); };", "U is a union"),
        ("interface I { void f(in fixed<5,2> p); };", "operation f: fixed has no form in CDR"),
        ("typedef long A[200][200]; interface I { A f(); };", "an array of 40000 items is too"),
        ("exception E {}; interface I { E f(); };", "E is not defined"),
        ('#include "x.idl"\ninterface I { X f(); };', "X is not defined (x.idl not found)"),
        ('#include "x.idl"\ninterface I : X { void f(); };', "X is not defined"),
    ],
)
def test_what_cannot_be_carried_is_told(text, why):
    definitions = read(text)
    assert why in of_interface(definitions, definitions.interface("I"))


def test_a_file_alone_gives_what_can_be_carried(builder):
    files, notes = build_types(builder.idl("Arm.idl"), "idl/Arm.idl")
    assert list(files) == ["Arm_idl.py"]
    assert notes == [
        "Arm.idl:72: Robot::Arm::Strange is left out: operation get: any has no form in CDR here"
    ]
    assert build_types(read("interface I { any f(); };"), "x.idl")[0] == {}


def test_a_method_that_gives_something_has_a_body_for_type_checkers():
    found = read_idl("interface I { long get(); void put(in long a); };")
    text = TypesCode(found, [("I",)]).text(["x.idl"])
    get, put = text.partition("def get(")[2].split("def put(")
    assert get.rstrip().endswith('"""\n        ...')
    assert "..." not in put
