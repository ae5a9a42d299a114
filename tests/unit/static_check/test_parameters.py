"""Values against types and constraints of every form, in both forms of writing them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from rtkit.profile.constraint_text import parse_constraint
from rtkit.profile.read import read_rtc
from rtkit.profile.rtc_model import ConfigurationParameter, DeclaredParameters
from rtkit.profile.write import write_rtc
from rtkit.report.finding import ERROR, WARNING

OLD = '<rts:ConfigurationData rts:name="patience" rts:data="0.5"/>'
CONSTRAINT, TYPE = "parameter-constraint", "parameter-type"


@pytest.fixture
def found(check: Any, text_of: Any, profile_of: Any) -> Any:
    """Check a value of a parameter that is declared so, and return what is found."""

    def run(type: str, constraint: str, value: str, default: str = "unlike") -> list[Any]:
        profile = read_rtc(profile_of("Motor").encode()).profile
        declared = ConfigurationParameter(
            "p", type, default, constraint=parse_constraint(constraint)
        )
        # Written and read, so that the form in XML is the one that is tested.
        changed = write_rtc(
            replace(profile, configuration_set=DeclaredParameters((declared,)))
        ).decode()
        escaped = value.replace("&", "&amp;").replace('"', "&quot;").replace("<", "&lt;")
        new = f'<rts:ConfigurationData rts:name="p" rts:data="{escaped}"/>'
        text = text_of("sensor-controller-motor").replace(OLD, new)
        return list(check(text, {"Motor.xml": changed}).findings)

    return run


@pytest.mark.parametrize(
    ("type", "constraint", "good", "bad"),
    [
        ("int", "0<=x<=10", ["0", "10"], ["11", "-1"]),
        ("double", "0<x<10", ["0.1"], ["0", "10"]),
        ("double", "x>=-1.5", ["-1.5", "1e9"], ["-1.6"]),
        ("short", "5", ["5"], ["6"]),
        ("string", "(RGB,GRAY)", ["RGB", "gray"], ["JPEG", ""]),
        ("string", "('RGB','GRAY')", ["RGB"], ["rgb"]),
        ("std::vector<double>", "0<=x<=1", ["0,1", "(0 0.5)"], ["0,2"]),
        ("vector<int>", "x>0,x<0,(7,8)", ["1,-1,7", "1"], ["1,1,7", "1,-1,9"]),
        ("string", "{near:0<=x<1,far:x>=1}", ["near:0,far:2", "{far:1}", "x"], ["near:1", "far:0"]),
        ("string", "not(like('*.exe'))", ["a.sh", ""], ["a.exe"]),
        ("string", 'like("/dev/tty%","%","_","!")', ["/dev/ttyUSB0"], ["/dev/null"]),
        ("string", "or(null(),x>0)", ["", "1"], ["0", "what"]),
        ("string", "and(not(null()),or((a,b),and(x>1,not(5))))", ["a", "2"], ["", "5", "c"]),
        ("int", "remark", ["1"], []),
        ("int", "or(auto,x>3)", ["4"], ["3"]),
        ("string", "on,off", ["on", "off"], ["maybe"]),
        ("bool", "(true,false)", ["1", "no", "TRUE"], []),
    ],
)
def test_constraints(
    type: str, constraint: str, good: list[str], bad: list[str], found: Any
) -> None:
    assert [value for value in good if found(type, constraint, value)] == []
    for value in bad:
        (finding,) = found(type, constraint, value)
        assert (finding.severity, finding.rule, finding.found) == (ERROR, CONSTRAINT, value)
        assert finding.allowed
        assert f"default.p of Motor0 cannot be {value!r}: it is to be " in finding.text


@pytest.mark.parametrize(
    ("type", "good", "bad"),
    [
        ("int", ["-3"], ["1.5", "x", "", "0x10"]),
        ("unsigned int", ["3"], ["-3"]),
        ("float", ["1", "1e-3", "nan"], ["1,2", "one"]),
        ("bool", ["true", "0"], ["2"]),
        ("String", ["", "what"], []),
        ("std::vector<int>", ["1,2", ""], ["1,x"]),
        ("Some::Type", ["", "what"], []),
    ],
)
def test_types(type: str, good: list[str], bad: list[str], found: Any) -> None:
    assert [value for value in good if found(type, "", value)] == []
    for value in bad:
        (finding,) = found(type, "", value)
        assert (finding.severity, finding.rule) == (ERROR, TYPE)
        assert (finding.found, finding.allowed) == (value, type)


def test_a_number_whose_default_is_a_list_may_be_a_list(found: Any) -> None:
    assert found("double", "x>0", "1,2", default="3,4") == []
    assert [f.rule for f in found("double", "x>0", "1,0", default="3,4")] == [CONSTRAINT]
    assert [f.rule for f in found("double", "x>0", "1,2", default="3")] == [TYPE]


def test_a_default_that_is_forbidden_is_not_the_fault_of_the_system(found: Any) -> None:
    (finding,) = found("int", "x>0", "0", default="0")
    assert (finding.severity, finding.rule) == (WARNING, CONSTRAINT)
    assert finding.text.endswith("; it is the default, which its own declaration forbids")


def test_create_strings_are_checked_too(check: Any, text_of: Any) -> None:
    text = text_of("sensor-controller-motor")
    old = 'rtsExt:value="Motor?manager_name=motor'
    assert old in text
    create = f"{old}&amp;conf.fast.patience=none&amp;conf.__x__.patience=y&amp;conf.default.z=1"
    (finding,) = check(text.replace(old, create)).findings
    assert (finding.severity, finding.rule, finding.found) == (ERROR, TYPE, "none")
    assert finding.text == "conf.fast.patience of Motor0 cannot be 'none': it is no number"
    assert finding.path.endswith("/rtsExt:Properties/@rtsExt:value")
    (finding,) = check(text.replace(old, 'rtsExt:value="Motor?a?b')).findings
    assert (finding.severity, finding.rule) == (ERROR, "create-string")
