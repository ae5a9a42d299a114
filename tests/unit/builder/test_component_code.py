"""What the module of a component says."""

from __future__ import annotations

from textwrap import dedent

import pytest

from rtkit.profile.common import ExtensionProperty
from rtkit.profile.rtc_model import (
    ActionDoc,
    Actions,
    ActionStatus,
    BasicDoc,
    ConfigurationDoc,
    ConfigurationParameter,
    DataPortDeclaration,
    DataPortDoc,
    DeclaredParameters,
    FsmTransition,
    ServiceInterface,
    ServicePortDeclaration,
    ServicePortDoc,
)


def ports(*items):
    return tuple(
        DataPortDeclaration(kind, name, type, "LEFT", doc=DataPortDoc(doc), unit=unit)
        for kind, name, type, doc, unit in items
    )


def settings(*items):
    return DeclaredParameters(tuple(ConfigurationParameter(*item) for item in items))


def test_a_component(builder):
    text = builder.code(
        "goalJudge",
        description="judge a goal",
        execution_rate=10.0,
        doc=BasicDoc(description="It judges.", creator="Me", license="none\nat all"),
        data_ports=ports(
            ("DataInPort", "in", "RTC::TimedLong", "A number", "m"),
            ("DataOutPort", "outVelocity", "TimedVelocity2D", None, None),
            ("DataInPort", "ports", "Img::TimedCameraImage", "", ""),
        ),
        configuration_set=settings(("gainP", "double", "1", "1/s"), ("class", "string", "a")),
        actions=Actions(
            on_execute=ActionStatus(True, ActionDoc("judge", "it is on", "it is judged")),
            on_error=ActionStatus(False),
            on_finalize=ActionStatus(True),
            on_action=ActionStatus(True),
        ),
    )
    assert text == dedent('''
        class GoalJudge(rt.Component):
            """Judge a goal.

            It judges.

            Author: Me

            License: none
            at all
            """

            type_name = "goalJudge"
            vendor = "me"
            category = "example"
            version = "1.0"
            rate = 10.0  # Hz

            in_ = rt.InPort(rt.TimedLong, doc="A number [m]")
            out_velocity = rt.OutPort(rt.TimedVelocity2D, name="outVelocity")
            ports_ = rt.InPort(images.TimedCameraImage)

            gain_p = rt.Parameter(1.0, name="gainP", unit="1/s")
            class_ = rt.Parameter("a")

            def on_finalize(self) -> None:
                """Clean up, once, at the end."""
                # <user code on_finalize>
                # </user code on_finalize>

            def on_execute(self, context: str) -> None:
                """Judge.

                Precondition: it is on

                Postcondition: it is judged
                """
                # <user code on_execute>
                # </user code on_execute>
    ''').strip("\n")


def test_services(builder):
    def offer(name, direction, type):
        return ServiceInterface(name, direction, type, idl_file="x/MyService.idl")

    text = builder.code(
        idl=("MyService.idl", "Arm.idl"),
        service_ports=(
            ServicePortDeclaration(
                "service",
                "LEFT",
                service_interfaces=(offer("service", "Provided", "SimpleService::MyService"),),
                doc=ServicePortDoc("echoes"),
            ),
            ServicePortDeclaration(
                "arm",
                "LEFT",
                service_interfaces=(
                    offer("a", "Required", "Robot::Arm::Base"),
                    offer("b", "Required", "Robot::Arm::Common"),
                    offer("c", "Provided", "No::Thing"),
                ),
            ),
            ServicePortDeclaration("none", "LEFT"),
        ),
    )
    assert text == dedent('''
        class Foo(rt.Component):
            """Component Foo."""

            vendor = "me"
            category = "example"
            version = "1.0"

            service = rt.ServicePort.provided(
                idl.MyService,
                type_name="SimpleService::MyService",
                doc="echoes",
            )
            arm = (
                rt.ServicePort(
                    interfaces=(rt.PortInterfaceProfile("c", "No::Thing", rt.Polarity.PROVIDED),),
                )
                .require(idl.Base, "a", type_name="Robot::Arm::Base")
                .require(idl.Common, "b", type_name="Robot::Arm::Common")
            )
            none = rt.ServicePort()

            def echo(self, msg: str) -> str:
                """Return the text."""
                # <user code service.echo>
                raise NotImplementedError
                # </user code service.echo>

            def get_echo_history(self) -> idl.EchoList:
                """The oldest first."""
                # <user code service.get_echo_history>
                raise NotImplementedError
                # </user code service.get_echo_history>

            def set_value(self, value: rt.Float) -> None:
                """Set value."""
                # <user code service.set_value>
                raise NotImplementedError
                # </user code service.set_value>

            def get_value(self) -> rt.Float:
                """Get value."""
                # <user code service.get_value>
                raise NotImplementedError
                # </user code service.get_value>

            def get_value_history(self) -> idl.ValueList:
                """Get value history."""
                # <user code service.get_value_history>
                raise NotImplementedError
                # </user code service.get_value_history>
    ''').strip("\n")


def test_two_ports_with_one_interface_get_servants(builder):
    interfaces = (ServiceInterface("i", "Provided", "SimpleService::MyService"),)
    text = builder.code(
        idl=("MyService.idl",),
        service_ports=tuple(
            ServicePortDeclaration(name, "LEFT", service_interfaces=interfaces)
            for name in ("one", "two")
        ),
    )
    assert text.startswith("class TwoMyService:\n")
    assert "def __init__(self, component: Foo) -> None:" in text
    assert "# <user code one.echo>" in text
    assert "# <user code TwoMyService.echo>" in text
    assert "implementation=TwoMyService," in text


def test_a_state_machine(builder):
    events = (
        FsmTransition("", "InitialState", "Idle"),
        FsmTransition("go", "Idle", "Busy.Deep", "if ready", "RTC::TimedLong"),
        FsmTransition("halt", "Busy.Deep", "Idle"),
    )
    text = builder.code(
        data_ports=(
            DataPortDeclaration("EventPort", "events", "Any", "LEFT", events=events),
            DataPortDeclaration("EventPort", "other", "Any", "LEFT"),
        ),
        actions=Actions(on_execute=ActionStatus(True), on_action=ActionStatus(True)),
    )
    assert text[text.index("class Foo(") :] == dedent('''
        class Foo(rt.FsmComponent):
            """Component Foo."""

            vendor = "me"
            category = "example"
            version = "1.0"
            execution_type = "PeriodicExecutionContext"

            event_port = "events"
            states: ClassVar = {
                "Idle": {"go": "Busy.Deep"},
                "Busy.Deep": {"halt": "Idle"},
            }
            events: ClassVar = {
                "go": rt.TimedLong,
                "halt": bytes,
            }
            state_classes: ClassVar = {
                "Idle": Idle,
                "Busy": Busy,
                "Busy.Deep": BusyDeep,
            }

            other = rt.EventPort()

            def on_execute(self, context: str) -> None:
                """Do the work of one period."""
                # <user code on_execute>
                # </user code on_execute>
                super().on_execute(context)

            def on_action(self, context: str) -> None:
                """React to a transition of the state machine."""
                # <user code on_action>
                # </user code on_action>

            def on_entry(self, state: str) -> None:
                """Enter a state."""
                # <user code on_entry>
                # </user code on_entry>
                super().on_entry(state)

            def on_exit(self, state: str) -> None:
                """Leave a state."""
                # <user code on_exit>
                # </user code on_exit>
                super().on_exit(state)

            def on_event(self, event: str, value: Any) -> str | None:
                """Take an event; return another state than the table says, or None.

                Conditions of the profile:
                go in Idle: if ready
                """
                # <user code on_event>
                return super().on_event(event, value)
                # </user code on_event>
    ''').strip("\n")


def test_each_state_has_a_class(builder):
    events = (
        FsmTransition("", "InitialState", "Idle"),
        FsmTransition("on_entry", "Idle", "Idle.Deep", "", "RTC::TimedLong"),
        FsmTransition("ab'c", "Idle.Deep", "Foo"),
    )
    built = builder.build(
        data_ports=(DataPortDeclaration("EventPort", "e", "Any", "LEFT", events=events),)
    )
    text = built.files["Foo.py"].text
    states = text[text.index("class Idle(") : text.index("class Foo(")]
    assert (
        states.rstrip()
        == dedent('''
        class Idle(rt.State):
            """State Idle."""

            component: Foo

            def on_entry(self) -> None:
                """Enter the state."""
                # <user code Idle.on_entry>
                # </user code Idle.on_entry>

            def on_exit(self) -> None:
                """Leave the state."""
                # <user code Idle.on_exit>
                # </user code Idle.on_exit>

            @rt.takes("on_entry")
            def on_entry_(self, value: rt.TimedLong) -> str | None:
                """Take on_entry, which leads to Idle.Deep."""
                # <user code Idle.on_entry_>
                return None
                # </user code Idle.on_entry_>


        class IdleDeep(rt.State):
            """State Idle.Deep."""

            component: Foo

            def on_entry(self) -> None:
                """Enter the state."""
                # <user code IdleDeep.on_entry>
                # </user code IdleDeep.on_entry>

            def on_exit(self) -> None:
                """Leave the state."""
                # <user code IdleDeep.on_exit>
                # </user code IdleDeep.on_exit>

            @rt.takes("ab'c")
            def ab_c(self, value: bytes) -> str | None:
                """Take ab'c, which leads to Foo."""
                # <user code IdleDeep.ab_c>
                return None
                # </user code IdleDeep.ab_c>


        class Foo2(rt.State):
            """State Foo."""

            component: Foo

            def on_entry(self) -> None:
                """Enter the state."""
                # <user code Foo2.on_entry>
                # </user code Foo2.on_entry>

            def on_exit(self) -> None:
                """Leave the state."""
                # <user code Foo2.on_exit>
                # </user code Foo2.on_exit>
    ''').strip()
    )


def test_a_drawing_has_the_states(builder):
    port = DataPortDeclaration(
        "EventPort", "events", "Any", "LEFT", events=(FsmTransition("go", "A", "B"),)
    )
    text = builder.code(data_ports=(port,), drawn={"X": {"go": "X.Y"}, "X.Y": {}})
    assert '"X": {"go": "X.Y"},' in text
    assert '"go": bytes,' in text


@pytest.mark.parametrize(
    ("type", "default", "code"),
    [
        ("int", "3", "3"),
        ("unsigned long", " -3 ", "-3"),
        ("uint16_t", "3", "3"),
        ("double", "3", "3.0"),
        ("float", "1e80", "1e80"),
        ("bool", "TRUE", "True"),
        ("std::string", " a ", '" a "'),
        ("", "3", '"3"'),
        ("int", "1,2", "(1, 2)"),
        ("double", "1,2", "(1.0, 2.0)"),
        ("std::vector<int>", "1 2", "(1, 2)"),
        ("vector<double>", "", "()"),
        ("short[]", "(1,2)", "(1, 2)"),
        ("sequence<string>", "a,b", '"a,b"'),
        ("char", "3", '"3"'),
    ],
)
def test_defaults(builder, type, default, code):
    built = builder.build(configuration_set=settings(("x", type, default)))
    assert f"    x = rt.Parameter({code})\n" in built.files["Foo.py"].text
    assert built.notes == ()


@pytest.mark.parametrize(
    ("type", "default", "code", "note"),
    [
        ("int", "", "0", "parameter x: no default for type int; it is 0"),
        ("double", " ", "0.0", "parameter x: no default for type double; it is 0.0"),
        ("int", "a", '"a"', "parameter x: default not an integer: 'a'; it is a text"),
        ("int", "1,b", '"1,b"', "parameter x: default not an integer: 'b'; it is a text"),
        ("bool", "1,0", '"1,0"', "parameter x: default not a truth value: '1,0'; it is a text"),
        ("vector<int>", "1.5", '"1.5"', "parameter x: default not an integer: '1.5'; it is a text"),
    ],
)
def test_defaults_that_are_none(builder, type, default, code, note):
    built = builder.build(configuration_set=settings(("x", type, default)))
    assert f"    x = rt.Parameter({code})\n" in built.files["Foo.py"].text
    assert built.notes == (note,)


def test_hints_of_parameters(builder):
    parameter = ConfigurationParameter(
        "x",
        "int",
        "1",
        doc=ConfigurationDoc(description="how\nmany", unit="m"),
        properties=(ExtensionProperty("__widget__", "slider.1"),),
    )
    text = builder.code(configuration_set=DeclaredParameters((parameter,)))
    assert 'x = rt.Parameter(1, unit="m", doc="how many", widget="slider.1")' in text


def test_names_that_are_taken_get_others(builder):
    built = builder.build(
        data_ports=ports(
            ("DataInPort", "a", "Any", "", ""),
            ("DataOutPort", "a", "Any", "", ""),
            ("DataOutPort", "", "Any", "", ""),
        ),
        service_ports=(ServicePortDeclaration("a", "LEFT"),),
        configuration_set=settings(("a", "int", "1"), ("a", "int", "1"), ("", "int", "1")),
    )
    text = built.files["Foo.py"].text
    for line in (
        "    a = rt.InPort(bytes)",
        "    a_2 = rt.OutPort(bytes)",
        "    port = rt.OutPort(bytes)",
        "    a_3 = rt.ServicePort()",
        "    a_ = rt.Parameter(1)",
        "    a_2_ = rt.Parameter(1)",
        "    parameter = rt.Parameter(1)",
    ):
        assert line in text.split("\n"), line
    assert built.notes == (
        "port 'a' is called a_2: its name is taken",
        "port '' is called port: it has no name",
        "port 'a' is called a_3: its name is taken",
        "configuration parameter 'a' is called a_2: its name is taken",
        "configuration parameter '' is called parameter: it has no name",
    )


def test_types_that_nobody_knows_pass_as_bytes(builder):
    built = builder.build(data_ports=ports(("DataInPort", "a", "Mine::T", "", "")))
    assert (
        'bytes, properties={"dataport.data_type": "IDL:Mine/T:1.0"}' in built.files["Foo.py"].text
    )
    assert built.notes == (
        "port a: Mine::T is not defined; values of that type pass as bytes"
        " (-I DIR tells where IDL files are)",
    )


def test_types_of_idl_files(builder):
    built = builder.build(
        idl=("Arm.idl",), data_ports=ports(("DataInPort", "a", "Robot::Arm::Point", "", ""))
    )
    assert "a = rt.InPort(idl.Point)" in built.files["Foo.py"].text
    types = built.files["Foo_idl.py"].text
    assert "class Point:" in types
    assert "class Status:" not in types
    assert '@shared("Robot::Arm::Point", "' in types


@pytest.mark.parametrize(
    ("type", "line", "note"),
    [
        ("ExtTrigExecutionContext", 'execution_type = "ExtTrigExecutionContext"', ""),
        ("PeriodicExecutionContext", "", ""),
        ("", "", ""),
        ("Mine", "", "execution context type Mine is not known"),
    ],
)
def test_execution_contexts(builder, type, line, note):
    built = builder.build(execution_type=type)
    assert ("execution_type" in built.files["Foo.py"].text) == bool(line)
    assert line in built.files["Foo.py"].text
    assert bool(built.notes) == bool(note)
    assert all(note in each for each in built.notes)


def test_a_negative_rate_is_none(builder):
    built = builder.build(execution_rate=-1.0)
    assert "rate =" not in built.files["Foo.py"].text
    assert built.notes == ("a rate of -1 Hz is none; it is left out",)


def test_a_name_that_no_type_can_have(builder):
    built = builder.build("a/b?")
    assert built.subject.type_name == "a_b_"
    assert list(built.files) == [
        "a_b.py",
        "tests/test_a_b.py",
        "README.md",
        "pyproject.toml",
        "system.xml",
        "RTC.xml",
    ]
    assert built.notes == ("'a/b?' can be no name of a type; it is called a_b_",)


def test_callbacks_that_are_not_asked_for_are_comments(builder):
    built = builder.build(actions=Actions(on_execute=ActionStatus(True)))
    comments = [
        line.strip() for line in built.files["Foo.py"].text.splitlines() if "# def on_" in line
    ]
    assert comments[:3] == [
        "# def on_initialize(self) -> None: ...",
        "# def on_finalize(self) -> None: ...",
        "# def on_startup(self, context: str) -> None: ...",
    ]
    assert len(comments) == 11
    assert not any("on_execute" in each or "on_action" in each for each in comments)
