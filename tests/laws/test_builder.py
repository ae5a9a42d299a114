"""Laws of the builder: whatever names and texts a profile holds, what is generated works."""

from __future__ import annotations

import ast
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from hypothesis import Phase, example, given, settings
from hypothesis import strategies as st

from rtkit.builder.component_files import Built, build
from rtkit.builder.merge import MergeOutcome, merge
from rtkit.builder.prepare import Sources
from rtkit.builder.profile_of import profile_of
from rtkit.builder.regions import split, stamped
from rtkit.builder.standard_types import KNOWN
from rtkit.idl.read import read_idl
from rtkit.profile.common import ExtensionProperty
from rtkit.profile.read import read_rtc, read_rts
from rtkit.profile.rtc_model import (
    ActionDoc,
    Actions,
    ActionStatus,
    BasicDoc,
    BasicInfo,
    ConfigurationDoc,
    ConfigurationParameter,
    DataPortDeclaration,
    DataPortDoc,
    DeclaredParameters,
    FsmTransition,
    RtcProfile,
    ServiceInterface,
    ServiceInterfaceDoc,
    ServicePortDeclaration,
    ServicePortDoc,
)
from rtkit.profile.write import write_rtc
from rtkit.testing import Trial

IDL = Path(__file__).parents[1] / "idl"
NASTY = [
    *("class", "in", "None", "self", "rt", "idl", "str", "tuple", "ports", "on_execute", "states"),
    *("type", "version", "__init__", "_x", "__x", "x_", "in_", "1st", "a b", "a-b", "A::B", "ÄÖ"),
    *(
        "日本語",
        "速度\n1",
        "\uff08全角\uff09",
        "ﬁ",
        "x²",
        "\u3000",
        "\U0001f916",
        "e\u0301",
        "\u200b",
        "\x85",
    ),
    *('"', "'", '"""', "'''", "\\", '\\"', "\\N{x}", "{x}", "%s", "\n", "\r\n", "\t", "#", "a\\"),
    *("# <user code imports>", "</user code members>", "# noqa: D100", "# type: ignore", "Args:"),
    *("Returns", "Note:\nx", "Raises:\n\n    X: y", "fmt: off", "-*- coding: latin-1 -*-", ""),
    *(
        " ",
        "*",
        "**",
        "*a",
        ".",
        "..",
        "/",
        "a/b",
        "a:b",
        "a?b&c=d",
        "x" * 130,
        "語" * 70,
        "wort " * 40,
        "a." * 60,
    ),
    *("logging", "rtkit", "pytest", "test_x", "TestIt", "conf.py", "Component", "TimedLong"),
    *("<br/>", "]]>", "&amp;", "| a | b |", "`code`", "<!-- -->", "[0123456789ab]", "\ufffd"),
    *("Made by rtbuild: [0123456789ab]", "§", "§Int8", "MODULE.py", "\U000e0001", "\u202e"),
]
TEXTS = st.sampled_from(NASTY) | st.text(
    st.characters(codec="utf-8", exclude_categories=["Cc", "Cs"], exclude_characters="\ufffe\uffff")
    | st.sampled_from("\t\n\r\\\"'#"),
    max_size=30,
)
OPTIONAL = st.none() | TEXTS
TYPES = st.sampled_from(
    [
        *("RTC::TimedLong", "TimedString", "RTC::TimedPose3D", "Img::TimedCameraImage", "Any"),
        *("Robot::Arm::Point", "Robot::Arm::Status", "Point", "Robot::Arm::Base", "Missing::T"),
    ]
)
INTERFACES = st.sampled_from(
    [
        *("SimpleService::MyService", "MyService", "Robot::Arm::Common", "Robot::Arm::Base"),
        *("Robot::Arm::Strange", "Robot::Arm::Point", "Missing::I", ""),
    ]
)
KINDS = TEXTS | st.sampled_from(
    [
        *("int", "double", "short", "std::string", "bool", "unsigned long", "long long", "char"),
        *("std::vector<double>", "std::vector<int>", "float[]"),
    ]
)
DEFAULTS = TEXTS | st.sampled_from(
    ["0", "1.5", "1,2", "-7", "true", "1e999", "nan", "9" * 80, "1,,2", "0x10", "(1 2)", " 3 "]
)
DATE = st.just("2020-01-01T00:00:00")
STATUSES = st.none() | st.builds(
    ActionStatus,
    st.booleans(),
    st.none() | st.builds(ActionDoc, OPTIONAL, OPTIONAL, OPTIONAL),
)
INFOS = st.builds(
    BasicInfo,
    name=TEXTS,
    component_type=st.just("STATIC"),
    activity_type=st.just("PERIODIC"),
    component_kind=st.just("DataFlowComponent"),
    category=TEXTS,
    vendor=TEXTS,
    version=TEXTS,
    execution_type=TEXTS | st.sampled_from(["PeriodicExecutionContext", "ExtTrigExecutionContext"]),
    creation_date=DATE,
    update_date=DATE,
    description=OPTIONAL,
    execution_rate=st.none() | st.sampled_from([0.0, -1.0, 10.0, 1000.0, 0.25]),
    doc=st.none() | st.builds(BasicDoc, OPTIONAL, OPTIONAL, OPTIONAL, OPTIONAL, OPTIONAL, OPTIONAL),
)
EVENTS = st.builds(FsmTransition, TEXTS, TEXTS, TEXTS, OPTIONAL, TYPES)
PORTS = st.builds(
    DataPortDeclaration,
    port_type=st.sampled_from(["DataInPort", "DataOutPort", "EventPort"]),
    name=TEXTS,
    type=TYPES | TEXTS,
    position=st.just("LEFT"),
    unit=OPTIONAL,
    comment=OPTIONAL,
    events=st.lists(EVENTS, max_size=3).map(tuple),
    doc=st.none() | st.builds(DataPortDoc, OPTIONAL, OPTIONAL, OPTIONAL, OPTIONAL, OPTIONAL),
)
OFFERS = st.builds(
    ServiceInterface,
    name=TEXTS,
    direction=st.sampled_from(["Provided", "Required"]),
    type=INTERFACES | TEXTS,
    idl_file=OPTIONAL,
    doc=st.none() | st.builds(ServiceInterfaceDoc, OPTIONAL),
)
SERVICES = st.builds(
    ServicePortDeclaration,
    name=TEXTS,
    position=st.just("LEFT"),
    comment=OPTIONAL,
    service_interfaces=st.lists(OFFERS, max_size=3).map(tuple),
    doc=st.none() | st.builds(ServicePortDoc, OPTIONAL, OPTIONAL),
)
PARAMETERS = st.builds(
    ConfigurationParameter,
    name=TEXTS,
    type=KINDS,
    default_value=DEFAULTS,
    unit=OPTIONAL,
    comment=OPTIONAL,
    doc=st.none() | st.builds(ConfigurationDoc, OPTIONAL, OPTIONAL, OPTIONAL, OPTIONAL),
    properties=st.lists(
        st.builds(ExtensionProperty, st.just("__widget__"), OPTIONAL), max_size=1
    ).map(tuple),
)
PROFILES = st.builds(
    RtcProfile,
    id=TEXTS,
    version=st.just("0.3"),
    basic_info=st.none() | INFOS,
    actions=st.none() | st.builds(Actions, *([STATUSES] * 14)),
    configuration_set=st.none()
    | st.builds(DeclaredParameters, st.lists(PARAMETERS, max_size=4).map(tuple)),
    data_ports=st.lists(PORTS, max_size=4).map(tuple),
    service_ports=st.lists(SERVICES, max_size=3).map(tuple),
)


def definitions() -> Any:
    text = "".join(f'#include "{name}"\n' for name in ("MyService.idl", "Arm.idl"))

    def find(name: str, _: str) -> tuple[str, str] | None:
        file = IDL / name
        return (name, file.read_text()) if file.exists() else None

    return read_idl(text, "all.idl", find, KNOWN)


DEFINITIONS = definitions()


def built(profile: RtcProfile) -> Built:
    return build(profile, Sources("stem", DEFINITIONS), ("Arm.idl",))


def texts(made: Built) -> dict[str, str]:
    return {
        name: stamped(file.text, has_regions=file.has_regions) for name, file in made.files.items()
    }


def nameless(text: str) -> RtcProfile:
    """Return a profile that has this text wherever one can stand."""
    info = BasicInfo(text, *["STATIC", "PERIODIC", "x"], text, text, text, text, "", "", text, text)
    doc = BasicDoc(*[text] * 6)
    status = ActionStatus(True, ActionDoc(text, text, text))
    port = DataPortDeclaration("DataInPort", text, text, "LEFT", doc=DataPortDoc(*[text] * 7))
    event = DataPortDeclaration(
        "EventPort", text, text, "LEFT", events=(FsmTransition(text, text, text, text, text),)
    )
    offer = ServiceInterface(text, "Provided", text, doc=ServiceInterfaceDoc(text))
    service = ServicePortDeclaration(text, "LEFT", text, (offer,), doc=ServicePortDoc(text, text))
    parameter = ConfigurationParameter(text, text, text, text, doc=ConfigurationDoc(*[text] * 6))
    return RtcProfile(
        id=text,
        version="0.3",
        basic_info=BasicInfo(
            **{name: getattr(info, name) for name in ("name", "vendor", "category", "version")},
            component_type="STATIC",
            activity_type="PERIODIC",
            component_kind="x",
            execution_type=text,
            creation_date="2020-01-01T00:00:00",
            update_date="2020-01-01T00:00:00",
            description=text,
            doc=doc,
        ),
        actions=Actions(*[status] * 14),
        configuration_set=DeclaredParameters((parameter,)),
        data_ports=(port, event),
        service_ports=(service,),
    )


def examples(function: Any) -> Any:
    for text in NASTY:
        function = example(nameless(text))(function)
    # A word so long that its paragraph is cut behind its label.
    status = ActionStatus(True, ActionDoc("#", None, "x" * 130))
    return example(replace(nameless("a"), actions=Actions(*[status] * 14)))(function)


@contextmanager
def loaded(made: Built) -> Iterator[ModuleType]:
    """Yield the test of a generated component, loaded with what it imports."""
    subject = made.subject
    files = texts(made)
    order = [f"{subject.types_module}.py"] if subject.has_types else []
    order += [f"{subject.module}.py", f"tests/test_{subject.module}.py"]
    names = []
    try:
        for file in order:
            name = file.removeprefix("tests/").removesuffix(".py")
            module = ModuleType(name)
            assert name not in sys.modules
            sys.modules[name] = module
            names.append(name)
            exec(compile(files[file], file, "exec"), module.__dict__)
        yield module
    finally:
        for name in names:
            del sys.modules[name]


def run_its_test(test: ModuleType) -> int:
    """Run the functions of a generated test, but for that with a manager; return how many."""
    count = 0
    for name, function in vars(test).items():
        if not name.startswith("test_") or "manager" in name or isinstance(function, ModuleType):
            continue
        marks = getattr(function, "pytestmark", [])
        wanted = [{}] if not marks else [{marks[0].args[0]: each} for each in marks[0].args[1]]
        for arguments in wanted:
            with Trial(test.Subject) as trial:
                function(trial=trial, **arguments)
            count += 1
    return count


@settings(max_examples=150, deadline=None)
@examples
@given(PROFILES)
def test_what_is_generated_compiles_and_passes_its_own_test(profile: RtcProfile) -> None:
    made = built(profile)
    assert texts(made) == texts(built(profile))
    for name, text in texts(made).items():
        if name.endswith(".py"):
            ast.parse(text)
            assert split(text).regions.keys() >= ({"imports"} if "_idl" not in name else set())
    project = tomllib.loads(texts(made)["pyproject.toml"])
    assert project["project"]["entry-points"]["rtkit.components"]
    with loaded(made) as test:
        assert run_its_test(test) >= 2


@settings(max_examples=60, deadline=None)
@examples
@given(PROFILES)
def test_the_profile_of_what_is_generated_stays_the_same(profile: RtcProfile) -> None:
    """Code to profile to code to profile: what the first profile says, the second says."""
    once = described(profile)
    twice = described(once)
    assert twice == once
    assert read_rtc(write_rtc(once), strict=True).profile == once


def described(profile: RtcProfile) -> RtcProfile:
    with loaded(built(profile)) as test, Trial(test.Subject) as trial:
        return profile_of(trial.component, "2020-01-01T00:00:00", {})


@settings(max_examples=60, deadline=None)
@given(PROFILES)
def test_the_profiles_beside_it_can_be_read(profile: RtcProfile) -> None:
    files = texts(built(profile))
    assert read_rtc(files["RTC.xml"].encode()).profile == read_again(profile)
    system = read_rts(files["system.xml"].encode(), strict=True).profile
    assert len(system.components) == 1


def read_again(profile: RtcProfile) -> RtcProfile:
    return read_rtc(write_rtc(profile)).profile


def checked_by_ruff(folder: Path, profiles: list[RtcProfile]) -> str:
    for number, profile in enumerate(profiles):
        for name, text in texts(built(profile)).items():
            file = folder / str(number) / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
    ruff = [sys.executable, "-m", "ruff", "check", "--no-cache", "--output-format", "concise"]
    done = subprocess.run([*ruff, str(folder)], capture_output=True, text=True, check=False)
    return done.stdout if done.returncode else ""


def test_the_linter_finds_nothing_in_nasty_names(tmp_path: Path) -> None:
    assert checked_by_ruff(tmp_path, [nameless(text) for text in NASTY]) == ""


# Not shrunk: what the linter says is small enough, and each step costs a process.
@settings(max_examples=60, deadline=None, phases=[Phase.generate])
@given(PROFILES)
def test_the_linter_finds_nothing(
    tmp_path_factory: pytest.TempPathFactory, profile: RtcProfile
) -> None:
    assert checked_by_ruff(tmp_path_factory.mktemp("ruff"), [profile]) == ""


LINES = st.lists(
    st.sampled_from(["x = 1", "    # mine", "", "        self.out.write(value)", "# <b>", "日本"]),
    max_size=4,
)


@settings(max_examples=60, deadline=None)
@given(PROFILES, PROFILES, st.data())
def test_code_of_users_survives(one: RtcProfile, other: RtcProfile, data: st.DataObject) -> None:
    """Generated again from another profile, a file keeps every region, or nothing is written."""
    before, after = built(one), built(other)
    for name, file in before.files.items():
        if not file.has_regions:
            continue
        text = stamped(file.text, has_regions=True)
        mine = {key: data.draw(LINES) for key in split(text).regions}
        edited = with_regions(text, mine)
        again = merge(edited, file.text, has_regions=True)
        assert again.assignment is MergeOutcome.SAME
        assert again.text == edited
        new = list(after.files.values())[list(before.files).index(name) % 2]
        merged = merge(edited, new.text, has_regions=True)
        if merged.assignment is not MergeOutcome.CONFLICT:
            kept = split(merged.text).regions
            for key, lines in mine.items():
                assert kept.get(key, []) == lines or all(
                    line.strip() in ("", "pass") for line in lines
                )


def with_regions(text: str, mine: dict[str, list[str]]) -> str:
    lines: list[str] = []
    skipping = False
    for line in text.split("\n"):
        name = line.strip().removeprefix("# <user code ").removesuffix(">")
        if skipping and not line.strip().startswith("# </user code "):
            continue
        skipping = False
        lines.append(line)
        if line.strip().startswith("# <user code "):
            lines += mine[name]
            skipping = True
    return "\n".join(lines)


@settings(max_examples=40, deadline=None)
@given(PROFILES, st.data())
def test_a_change_to_the_generated_part_is_noticed(profile: RtcProfile, data: Any) -> None:
    file = next(iter(built(profile).files.values()))
    text = stamped(file.text, has_regions=True)
    lines = text.split("\n")
    inside = False
    places = []
    for number, line in enumerate(lines):
        inside = inside or line.strip().startswith("# <user code ")
        if not inside and line.strip() and "Made by rtbuild" not in line:
            places.append(number)
        if line.strip().startswith("# </user code "):
            inside = False
    number = data.draw(st.sampled_from(places))
    lines[number] += "  # mine"
    merged = merge("\n".join(lines), file.text, has_regions=True)
    assert merged.assignment is MergeOutcome.CONFLICT
    assert merged.line == number + 1
