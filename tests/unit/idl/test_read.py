"""What IDL files say: declarations, names, constants, documentation, and where they are wrong."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtkit.idl.model import (
    ArrayOf,
    Attribute,
    Basic,
    BasicKind,
    Constant,
    Direction,
    EnumDeclaration,
    EnumValue,
    Field,
    InterfaceDeclaration,
    Named,
    Opaque,
    Operation,
    OperationParameter,
    SequenceOf,
    StructDeclaration,
    Typedef,
)
from rtkit.idl.read import read_idl
from rtkit.idl.source import InvalidIdl

FILES = Path(__file__).parents[2] / "idl"
KNOWN = {("RTC", "Time"), ("RTC", "TimedLong")}


def read(text, **more):
    return read_idl(text, "a.idl", **more)


def fails(text, **more):
    with pytest.raises(InvalidIdl) as caught:
        read(text, **more)
    return str(caught.value)


def from_file(name):
    return read_idl((FILES / name).read_text(), name, known=KNOWN)


def test_a_service_is_read_with_its_documentation():
    found = from_file("MyService.idl")
    service = found.interface("SimpleService::MyService")
    assert service.doc == "Echoes texts and keeps a number.\n\nWhat was given is remembered."
    assert service.operations == (
        Operation(
            "echo",
            Basic("string"),
            (OperationParameter(Direction.IN, "msg", Basic("string")),),
            doc="Return the text.",
        ),
        Operation("get_echo_history", Named(("SimpleService", "EchoList")), doc="the oldest first"),
        Operation("set_value", None, (OperationParameter(Direction.IN, "value", Basic("float")),)),
        Operation("get_value", Basic("float")),
        Operation("get_value_history", Named(("SimpleService", "ValueList"))),
    )
    assert found.find("SimpleService::EchoList").type == SequenceOf(Basic("string"))
    assert found.interface("SimpleService::EchoList") is None
    assert found.find("MyService") is None


def test_a_manipulator_is_read():
    found = from_file("Arm.idl")
    assert found.missing == ("BasicDataType.idl",)
    constants = {d.path[-1]: d.value for d in found.by_path.values() if isinstance(d, Constant)}
    assert constants == {
        "MAX_POINTS": 15,
        "HOME": -0.5,
        "GREETING": 'hello "arm"\n',
        "IS_REAL": False,
        "FIRST": EnumValue(("Robot", "Arm", "Mode"), "MOVING"),
    }
    assert found.find("Robot::Arm::Mode").members == ("IDLE", "MOVING", "FAULT")
    assert found.find("Robot::Arm::HgMatrix").type == ArrayOf(Basic("double"), (3, 4))
    assert found.find("Robot::Arm::Angles").type == ArrayOf(Basic("double"), (6,))
    point = Named(("Robot", "Arm", "Point"))
    assert found.find("Robot::Arm::Path").type == SequenceOf(point, 15)
    result = found.find("Robot::Result")
    assert result.doc == "How an operation ended."
    assert result.fields[0] == Field("id", Basic("long"), "0 when all was well")
    types = {field.name: field.type for field in found.find("Robot::Arm::Status").fields}
    assert types["tm"] == Named(("RTC", "Time"))
    assert types["last"] == Named(("Robot", "Result"))
    assert types["codes"] == ArrayOf(Basic("unsigned short"), (2,))
    assert types["count"] == Basic("unsigned long long")
    common = found.interface("Robot::Arm::Common")
    assert common.bases == (("Robot", "Arm", "Base"),)
    move = common.operations[1]
    assert [(p.direction, p.name) for p in move.parameters] == [
        ("in", "from"),
        ("in", "to"),
        ("inout", "ticket"),
    ]
    assert move.raises == (("Robot", "Arm", "Refused"), ("Robot", "Arm", "Busy"))
    assert found.find("Robot::Arm::Busy") == StructDeclaration(
        ("Robot", "Arm", "Busy"), found.find("Robot::Arm::Busy").place, (), is_exception=True
    )
    base = found.interface("Robot::Arm::Base")
    assert base.attributes == (
        Attribute("mode_now", Named(("Robot", "Arm", "Mode")), is_readonly=True),
        Attribute("speed", Basic("double")),
    )


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("1 + 2 * 3", 7),
        ("(1 + 2) * 3", 9),
        ("-7 / 2", -3),
        ("-7 % 2", -1),
        ("7.0 / 2", 3.5),
        ("~0", -1),
        ("1 << 4 | 1", 17),
        ("6 & 3 ^ 1", 3),
        ("0x1F", 31),
        ("017", 15),
        ("0", 0),
        ("1e3", 1000.0),
        (".5", 0.5),
        ("'a'", "a"),
        (r"'\n'", "\n"),
        (r'"\x41\102\u0043\q" "\\"', "ABCq\\"),
        ("TRUE", True),
        ("N", 4),
        ("::M::N - N", 0),
    ],
)
def test_constants_have_values(expression, value):
    found = read(f"module M {{ const long N = 4; const long X = {expression}; }};")
    assert found.find("M::X").value == value
    assert type(found.find("M::X").value) is type(value)


@pytest.mark.parametrize(
    ("expression", "why"),
    [
        ("1 / 0", "division by zero"),
        ("1 % 0", "division by zero"),
        ("1 << 99", "shift by 99"),
        ("1.5 & 1", "1.5 is not an integer"),
        ('"a" + 1', "'a' is not a number"),
        ("TRUE + 1", "True is not a number"),
        ("08", "08 is no octal number"),
        ("S", "S is no constant"),
        ("T", "T is not defined"),
    ],
)
def test_constants_without_value_are_refused(expression, why):
    text = f"struct S {{ long n; }};\nconst long X = {expression};"
    assert fails(text) == f"a.idl:2: {why}"


def test_names_are_looked_for_from_the_inside_out():
    found = read(
        "struct T { long a; };\n"
        "module M { struct T { long b; }; "
        "module N { struct U { T near; ::T far; M::T full; }; }; };"
    )
    types = [field.type for field in found.find("M::N::U").fields]
    assert types == [Named(("M", "T")), Named(("T",)), Named(("M", "T"))]


def test_an_interface_knows_the_names_of_its_bases():
    found = read(
        "interface A { struct P { long n; }; const long N = 2; };\n"
        "interface B : A { typedef long Row[N]; P get(); };\n"
        "interface C : B {};\n"
        "struct U { C::P p; };"
    )
    assert found.interface("B").operations[0].result == Named(("A", "P"))
    assert found.find("B::Row").type == ArrayOf(Basic("long"), (2,))
    assert found.find("U").fields[0].type == Named(("A", "P"))


def test_modules_are_opened_again_and_names_announced():
    found = read(
        "module M { interface I; struct S; };\n"
        "module M { struct S { long n; }; interface J { I get(in S s); }; };\n"
        "module M { interface I { S get(); }; };"
    )
    assert isinstance(found.find("M::I"), InterfaceDeclaration)
    assert isinstance(found.find("M::S"), StructDeclaration)
    assert list(found.by_path) == [("M", "S"), ("M", "J"), ("M", "I")]


def test_a_structure_may_hold_a_sequence_of_itself():
    found = read("struct T; typedef sequence<T> Ts; struct T { long n; Ts kids; sequence<T> k; };")
    assert found.find("T").fields[2].type == SequenceOf(Named(("T",)))


def test_structures_may_inherit():
    found = read("struct A { long a; }; struct B : A { long b; };")
    assert [field.name for field in found.find("B").fields] == ["a", "b"]


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("union U switch (long) { case 1: long n; default: string s; };", BasicKind.UNION),
        ("valuetype U { public long n; private U next; factory make(in long n); };", "valuetype"),
        ("valuetype U : Base supports I { void f(); };", BasicKind.VALUETYPE),
        ("native U;", BasicKind.NATIVE),
        ("interface U;", BasicKind.FORWARD),
    ],
)
def test_what_cannot_be_carried_is_known_by_name(text, kind):
    found = read(f"interface I {{ void g(); }}; valuetype Base {{}}; {text}")
    assert found.find("U") == Opaque(("U",), found.find("U").place, kind)


def test_annotations_integers_of_idl4_and_escaped_names():
    found = read(
        '@final @topic(name="a", size=3) struct S { @key int32 _module; @default(3) uint8 b; };\n'
        "enum E { @value(1) A, B, };\n"
        "interface _interface { long _in(in long _out); };"
    )
    assert found.find("S").fields == (Field("module", Basic("int32")), Field("b", Basic("uint8")))
    assert found.find("E").members == ("A", "B")
    assert found.interface("interface").operations[0].parameters[0].name == "out"


def test_every_basic_type():
    words = [
        *("short", "long", "long long", "unsigned short", "unsigned long", "unsigned long long"),
        *("float", "double", "long double", "char", "wchar", "boolean", "octet", "any", "Object"),
        *("string", "wstring"),
    ]
    fields = "".join(f"{word} f{n};" for n, word in enumerate(words))
    found = read(f"struct S {{ {fields} fixed<5,2> price; map<string, long> m; }};")
    assert [field.type for field in found.find("S").fields] == [
        *map(Basic, words),
        Basic("fixed"),
        Basic("map"),
    ]


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("module M { struct S { long n } ; };", "1: unexpected '}'; expected ',' or '[' or ';'"),
        ("module M {\n struct S { long n; };", "2: the file ends too early"),
        ("struct S { long n; };\n\n%%", "3: unexpected '%'"),
        ("struct S { long n; };\n ` ", "2: unexpected character '`'"),
        ("module M { struct S { T n; }; };", "1: T is not defined"),
        ("struct S { long n; };\nstruct S { long n; };", "2: S is declared already (a.idl:1)"),
        ("struct M { long n; };\nmodule M { };", "2: M is declared already (a.idl:1)"),
        ("module M { };\nstruct M { long n; };", "2: M is used already"),
        ("enum E { A };\nenum F { A };", "2: A is used already"),
        ("struct S { long n; double n; };", "1: S has two members n"),
        ("typedef long T[0];", "1: 0 is no size"),
        ("typedef string<1.5> T; typedef sequence<long, 1.5> U;", "1: 1.5 is no size"),
        ("const long N = 1;\nstruct S { N n; };", "2: N is no type"),
        ("struct S { long n; };\ninterface I : S {};", "2: S is no complete interface"),
        ("interface I { void f(long n); };", "1: unexpected 'long'"),
        ("interface I { void f() raises (E); };", "1: E is not defined"),
    ],
)
def test_mistakes_are_told_with_their_line(text, why):
    assert fails(text).startswith(f"a.idl:{why}")


def test_what_an_absent_file_may_define_is_left_open():
    found = read('#include "Other.idl"\nmodule M { struct S { Other::T n; T2 m; Other::T o; }; };')
    assert found.missing == ("Other.idl",)
    assert found.find("Other::T").kind is BasicKind.MISSING
    assert found.find("M::S").fields[0].type == Named(("Other", "T"))


def test_known_names_need_no_definition():
    found = read("struct S { RTC::TimedLong a; };", known=KNOWN)
    assert found.find("S").fields[0].type == Named(("RTC", "TimedLong"))
    assert "T is not defined" in fails("struct S { T a; };", known=KNOWN)


def test_declarations_tell_their_place_across_files():
    files = {"b.idl": "\nmodule B {\n struct P { long n; };\n};\n"}
    found = read(
        '#include "b.idl"\n\nstruct Q { B::P p; };', find=lambda name, _: (name, files[name])
    )
    assert str(found.find("B::P").place) == "b.idl:3"
    assert str(found.find("Q").place) == "a.idl:3"
    files["b.idl"] = "module B {\n struct P { long n };\n};\n"
    with pytest.raises(InvalidIdl, match=r"^b.idl:2: unexpected '}'"):
        read('#include "b.idl"\n', find=lambda name, _: (name, files[name]))


def test_enumerations_and_typedefs_tell_what_they_are():
    found = read(
        "/// Which way.\nenum Way { LEFT, RIGHT };\n\n// Two of them.\ntypedef Way Ways[2];"
    )
    assert found.find("Way") == EnumDeclaration(
        ("Way",), found.find("Way").place, ("LEFT", "RIGHT"), doc="Which way."
    )
    ways = found.find("Ways")
    assert ways == Typedef(
        ("Ways",), ways.place, ArrayOf(Named(("Way",)), (2,)), doc="Two of them."
    )


@pytest.mark.parametrize(
    "word", ["map", "int8", "uint64", "factory", "supports", "native", "getraises", "component"]
)
def test_a_word_that_is_no_keyword_there_is_a_name(word):
    found = read(
        f"struct T {{ long a; }}; struct S {{ T {word}; long b; }}; "
        f"interface I {{ T {word}(in T {word}); }};"
    )
    assert found.by_path["S",].fields[0] == Field(word, Named(("T",)))
    operation = found.interface("I").operations[0]
    assert (operation.name, operation.parameters[0].name) == (word, word)


@pytest.mark.parametrize("word", ["map", "int8"])
def test_a_type_may_have_the_name_of_a_later_type(word):
    found = read(f"struct {word} {{ long a; }}; struct S {{ {word} m; ::{word} n; }};")
    assert [each.type for each in found.by_path["S",].fields] == [Named((word,))] * 2


def test_types_of_idl_4_are_types_where_nothing_has_their_name():
    found = read("struct S { int8 a; uint64 b; map<string, map<int8, long> > c; };")
    kinds = [each.type for each in found.by_path["S",].fields]
    assert kinds == [Basic("int8"), Basic("uint64"), Basic("map")]
    assert fails("struct S { int9 a; };") == "a.idl:1: int9 is not defined"
    assert fails("struct S { list<long, long> a; };") == "a.idl:1: unexpected '<' after list"


def test_what_the_broker_defines_needs_no_definition():
    found = read("struct S { CORBA::TypeCode code; sequence< ::CORBA::Policy> all; };")
    declared = found.by_path["CORBA", "TypeCode"]
    assert isinstance(declared, Opaque)
    assert declared.kind is BasicKind.BROKER
    own = read("module CORBA { struct TypeCode { long a; }; }; struct S { CORBA::TypeCode c; };")
    assert isinstance(own.by_path["CORBA", "TypeCode"], StructDeclaration)
