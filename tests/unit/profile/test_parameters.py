"""Parameters of system profiles: variables, conditions, includes, prefixes, and their errors."""

from __future__ import annotations

from pathlib import Path

import pytest

from rtkit.errors import InvalidDocument, Malformed, UsageProblem
from rtkit.profile import rts_model as m
from rtkit.profile.forms import has_parameters
from rtkit.profile.parameters import GivenValue, SystemParameters
from rtkit.profile.parameters.naming import prefixed
from rtkit.profile.parameters.reading import SystemReading, read_system
from rtkit.profile.parameters.texts import holds, substituted
from rtkit.profile.read import read_rts
from rtkit.profile.write import write_rts

HEAD = """<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile xmlns:rts="http://www.openrtp.org/namespaces/rts"
  xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext"
  xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xmlns:rtkit="urn:rtkit:profile"
  rts:id="RTSystem:Me:Robot:1.0" rts:version="0.2"
  rts:creationDate="2025-01-01T00:00:00" rts:updateDate="2025-01-01T00:00:00">
"""
CAMERA = """<rts:Components rts:id="RTC:Me:test:Camera:1.0" rts:pathUri="localhost/{0}.rtc"
  rts:instanceName="{0}" rts:isRequired="true" {1}>
  <rts:DataPorts rts:name="{0}.image"/>
  <rts:ConfigurationSets rts:id="default">
    <rts:ConfigurationData rts:name="noise" rts:data="{2}"/>
  </rts:ConfigurationSets>
  <rts:ExecutionContexts rts:id="0" rts:kind="PERIODIC" rts:rate="10" {3}/>
</rts:Components>
"""
WIRE = """<rts:DataPortConnectors rts:connectorId="{0}" rts:name="{0}" rts:dataType="TimedLong"
  rts:interfaceType="corba_cdr" rts:dataflowType="push">
  <rts:sourceDataPort rts:componentId="RTC:Me:test:Camera:1.0" rts:instanceName="{1}"
    rts:portName="{1}.image"/>
  <rts:targetDataPort rts:componentId="RTC:Me:test:Camera:1.0" rts:instanceName="{2}"
    rts:portName="{2}.image"/>
</rts:DataPortConnectors>
"""
ORDER = """<rts:Activation>
  <rts:targets rts:sequence="1"><rts:WaitTime rts:waitTime="1"/>
    <rts:TargetComponent rts:componentId="RTC:Me:test:Camera:1.0" rts:instanceName="{0}"
      rts:id="0"/></rts:targets>
  <rts:targets rts:sequence="2">
    <rts:Preceding rts:timeout="1"><rts:PrecedingComponents rts:id="0"
      rts:componentId="RTC:Me:test:Camera:1.0" rts:instanceName="{0}"/></rts:Preceding>
    <rts:TargetComponent rts:componentId="RTC:Me:test:Camera:1.0" rts:instanceName="{1}"
      rts:id="0"/></rts:targets>
</rts:Activation>
"""
END = "</rts:RtsProfile>\n"


def camera(name: str, noise: str = "1", own: str = "", context: str = "") -> str:
    return CAMERA.format(name, own, noise, context)


def variable(name: str, default: str | None = None) -> str:
    given = "" if default is None else f' rtkit:default="{default}"'
    return f'<rtkit:Variable rtkit:name="{name}"{given}/>\n'


def include(file: str, prefix: str = "", values: str = "", own: str = "") -> str:
    start = f'<rtkit:Include rtkit:file="{file}" rtkit:prefix="{prefix}" {own}>'
    return f"{start}{values}</rtkit:Include>\n"


def value(name: str, text: str) -> str:
    return f'<rtkit:Value rtkit:name="{name}" rtkit:value="{text}"/>'


def read(
    *parts: str, given: dict[str, str] | None = None, prefix: str = "", source: str = "robot.xml"
) -> SystemReading:
    values = [GivenValue(key, text, f"--set {key}={text}") for key, text in (given or {}).items()]
    document = (HEAD + "".join(parts) + END).encode()
    return read_system(document, source, SystemParameters(tuple(values), prefix))


def profile(*parts: str, given: dict[str, str] | None = None, prefix: str = "") -> m.RtsProfile:
    return read(*parts, given=given, prefix=prefix).profile


def noise(made: m.RtsProfile, name: str = "Camera0") -> str | None:
    (component,) = (each for each in made.components if each.instance_name == name)
    return component.configuration_sets[0].data[0].data


@pytest.mark.parametrize(
    ("text", "made"),
    [
        ("plain", "plain"),
        ("${a}${b}", "1two"),
        ("x-${a}-$b", "x-1-$b"),
        ("$${a} costs $$", "${a} costs $"),
        ("$$${a}", "$1"),
    ],
)
def test_a_reference_stands_for_its_value(text: str, made: str) -> None:
    assert substituted(text, {"a": "1", "b": "two"}) == made


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("${nose}", r"no variable nose \(did you mean noise\?\)"),
        ("${zebra}", 'no variable zebra; declare it: <rtkit:Variable rtkit:name="zebra"/>'),
        ("${noise", "no closing brace"),
        ("${noise:-3}", "the default of noise stands where"),
        ("${}", "no variable "),
    ],
)
def test_a_wrong_reference_is_refused(text: str, why: str) -> None:
    with pytest.raises(Malformed, match=why):
        substituted(text, {"noise": "3"})


@pytest.mark.parametrize(
    ("condition", "is_met"),
    [
        ("true", True),
        ("Off", False),
        ("${yes}", True),
        (" ${side} == left ", True),
        ("${side}!=left", False),
        ("'${side}' == \"left\"", True),
        ("${empty} == ''", True),
        ("${trick} == 1", False),
    ],
)
def test_a_condition_is_a_boolean_or_compares_texts(condition: str, is_met: bool) -> None:
    values = {"yes": "yes", "side": "left", "empty": "", "trick": "1 == 1"}
    assert holds(condition, values) is is_met


@pytest.mark.parametrize("condition", ["", "maybe", "1 + 1", "__import__('os')", "${no}"])
def test_another_condition_is_refused(condition: str) -> None:
    with pytest.raises(Malformed, match=r"neither true nor false|no variable"):
        holds(condition, {})


def test_a_variable_has_its_default_or_what_is_given() -> None:
    parts = (camera("Camera0", "${noise}"), variable("noise", "2"))
    assert noise(profile(*parts)) == "2"
    assert noise(profile(*parts, given={"noise": "3"})) == "3"


def test_a_default_may_use_variables_before_it() -> None:
    parts = (camera("Camera0", "${both}"), variable("a", "1"), variable("both", "${a}2"))
    assert noise(profile(*parts, given={"a": "4"})) == "42"


def test_texts_of_a_profile_without_variables_stay() -> None:
    assert noise(profile(camera("Camera0", "${HOME}", 'rtkit:if="true"'))) == "${HOME}"


def test_a_number_stands_beside_what_other_tools_read() -> None:
    parts = (camera("Camera0", context='rtkit:rate="${rate}"'), variable("rate", "20"))
    assert profile(*parts).components[0].execution_contexts[0].rate == 20.0
    with pytest.raises(InvalidDocument, match=r"robot.xml:13: rts:rate is 'x'; allowed: a finite"):
        profile(*parts, given={"rate": "x"})


def test_a_variable_in_a_number_tells_where_to_write_it() -> None:
    bad = camera("Camera0").replace('rts:rate="10"', 'rts:rate="${rate}"')
    with pytest.raises(InvalidDocument, match=r"beside it rtkit:rate='\$"):
        profile(bad, variable("rate", "20"))


def test_what_names_a_component_that_is_left_out_is_left_out() -> None:
    parts = (
        camera("Camera0"),
        camera("Camera1", own='rtkit:if="${second}"'),
        camera("Camera2", own='rtkit:unless="${second} == no"'),
        WIRE.format("w", "Camera0", "Camera1"),
        ORDER.format("Camera1", "Camera0"),
        variable("second", "yes"),
    )
    whole = profile(*parts)
    assert [each.instance_name for each in whole.components] == ["Camera0", "Camera1", "Camera2"]
    assert len(whole.data_port_connectors) == 1
    less = profile(*parts, given={"second": "no", "Camera1.noise": "9"})
    assert [each.instance_name for each in less.components] == ["Camera0"]
    assert less.data_port_connectors == ()
    assert less.activation is not None
    (step,) = less.activation.targets
    assert step.preceding is not None
    assert step.preceding.preceding_components == ()


def test_a_parameter_is_set_in_the_set_that_is_meant() -> None:
    made = profile(camera("Camera0"), given={"Camera0.gain": "5", "Camera0.default.noise": "6"})
    (default,) = made.components[0].configuration_sets
    assert [(each.name, each.data) for each in default.data] == [("noise", "6"), ("gain", "5")]
    bare = camera("Camera0").replace('rts:ConfigurationSets rts:id="default"', "x").split("<x>")[0]
    bare += "</rts:Components>\n"
    (made_set,) = profile(bare, given={"Camera0.a.b": "5"}).components[0].configuration_sets
    assert made_set == m.ConfigurationSet("default", (m.ConfigurationData("a.b", "5"),))


def test_the_longest_name_of_a_component_is_meant() -> None:
    made = profile(camera("a"), camera("a.b"), given={"a.b.noise": "7"})
    assert (noise(made, "a"), noise(made, "a.b")) == ("1", "7")


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ({"nose": "1"}, r"--set nose=1: no variable nose \(did you mean noise\?\)"),
        ({"zebra": "1"}, "no variable zebra; there are noise"),
        ({"Camra0.noise": "1"}, r"no component Camra0 \(did you mean Camera0.noise\?\)"),
        ({"Motor.x": "1"}, "no component Motor; there are Camera0"),
    ],
)
def test_a_value_for_nothing_is_refused(given: dict[str, str], why: str) -> None:
    with pytest.raises(UsageProblem, match=why):
        profile(camera("Camera0", "${noise}"), variable("noise", "2"), given=given)


@pytest.mark.parametrize(
    ("parts", "why"),
    [
        (
            (camera("Camera0"), variable("noise")),
            r":15: variable noise has no value, .* \(--set noise=VALUE\)",
        ),
        ((camera("Camera0", "${nose}"), variable("noise", "1")), ":11: no variable nose"),
        ((variable("a", "1"), variable("a", "2")), ":8: variable a is declared twice"),
        ((variable("a b", "1"),), ":7: not a name of a variable: 'a b'"),
        ((camera("Camera0", own='rtkit:if="maybe"'),), ":8: 'maybe' is 'maybe', neither true"),
        ((camera("Camera0", own='rtkit:iff="1"'),), r":8: no such attribute: rtkit:iff \(did you"),
        (("<rtkit:Includ/>",), r":7: no such element: rtkit:Includ \(did you mean Include\?\)"),
        ((include("no.xml"),), ":7: no file no.xml, neither beside robot.xml nor"),
    ],
)
def test_an_error_names_file_and_line(parts: tuple[str, ...], why: str) -> None:
    with pytest.raises(InvalidDocument, match=f"^robot.xml{why}"):
        profile(*parts)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder of profiles, in which the test works."""
    (tmp_path / "here" / "sub").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "here")
    return tmp_path / "here"


def put(file: Path, *parts: str) -> None:
    file.write_text(HEAD + "".join(parts) + END, encoding="utf-8")


def test_a_profile_is_included_several_times(folder: Path) -> None:
    put(
        folder / "arm.xml",
        camera("Camera0", "${noise}"),
        camera("Camera1"),
        WIRE.format("w", "Camera0", "Camera1"),
        ORDER.format("Camera0", "Camera1"),
        variable("noise", "2"),
    )
    made = profile(
        WIRE.format("own", "a.Camera0", "b.Camera1"),
        variable("left", "3"),
        include("arm.xml", "a.", value("noise", "${left}")),
        include("arm.xml", "b.", value("Camera1.noise", "8")),
        given={"b.noise": "4", "a.Camera1.noise": "5"},
    )
    names = ("a.Camera0", "a.Camera1", "b.Camera0", "b.Camera1")
    assert [noise(made, name) for name in names] == ["3", "5", "4", "8"]
    assert [each.connector_id for each in made.data_port_connectors] == ["own", "a.w", "b.w"]
    assert made.activation is not None
    targets = [each.target_component.instance_name for each in made.activation.targets]
    assert targets == list(names)
    assert read_rts(write_rts(made), strict=True).profile == made


def test_an_include_may_be_left_out(folder: Path) -> None:
    put(folder / "arm.xml", camera("Camera0"))
    made = profile(
        camera("Own0"),
        WIRE.format("w", "Own0", "a.Camera0"),
        include("arm.xml", "a.", own='rtkit:if="no"'),
        given={"a.Camera0.noise": "1"},
    )
    assert [each.instance_name for each in made.components] == ["Own0"]
    assert made.data_port_connectors == ()


def test_includes_are_found_below_the_folder_and_on_the_path(folder: Path) -> None:
    put(folder / "sub" / "one.xml", include("two.xml", "t."))
    put(folder / "sub" / "two.xml", camera("Camera0"))
    other = folder.parent / "other"
    other.mkdir()
    put(other / "far.xml", camera("Camera1"))
    document = HEAD + include("sub/one.xml", "o.") + include("far.xml") + END
    made = read_system(document.encode(), "<stdin>", folders=[str(other)]).profile
    assert [each.instance_name for each in made.components] == ["o.t.Camera0", "Camera1"]


@pytest.mark.parametrize("file", ["../secret.xml", "link.xml", "{}/secret.xml"])
def test_an_include_outside_of_the_granted_folders_is_refused(folder: Path, file: str) -> None:
    put(folder.parent / "secret.xml", camera("Camera0"))
    (folder / "link.xml").symlink_to(folder.parent / "secret.xml")
    with pytest.raises(InvalidDocument, match=r"robot.xml:7: .* is outside of .*here"):
        profile(include(file.format(folder.parent), "a."))


def test_a_loop_of_includes_is_refused(folder: Path) -> None:
    put(folder / "robot.xml", include("other.xml", "a."))
    put(folder / "other.xml", "\n", include("./robot.xml", "b."))
    why = "^./other.xml:8: a profile includes itself: robot.xml -> other.xml -> "
    with pytest.raises(InvalidDocument, match=why.replace("./other", "other")):
        profile(include("other.xml", "a."))


def test_includes_that_grow_without_bound_are_refused(folder: Path) -> None:
    for number in range(12):
        twice = "".join(include(f"{number + 1}.xml", f"{side}.") for side in "ab")
        put(folder / f"{number}.xml", twice)
    put(folder / "12.xml", camera("Camera0"))
    with pytest.raises(InvalidDocument, match="more than 1000 profiles are included"):
        profile(include("0.xml"))


def test_an_error_of_an_included_profile_names_its_file(folder: Path) -> None:
    put(folder / "arm.xml", camera("Camera0", "${nose}"), variable("noise", "2"))
    with pytest.raises(InvalidDocument, match=r"^arm.xml:11: no variable nose"):
        profile(include("arm.xml", "a."))
    put(folder / "arm.xml", "<!DOCTYPE a>")
    with pytest.raises(InvalidDocument, match=r"^arm.xml:"):
        profile(include("arm.xml", "a."))


def test_a_value_that_an_include_does_not_take_is_refused(folder: Path) -> None:
    put(folder / "arm.xml", camera("Camera0"), variable("noise", "2"))
    why = r"robot.xml:8: arm.xml has no variable nose \(did you mean noise\?\)"
    with pytest.raises(InvalidDocument, match=why):
        profile(include("arm.xml", "a.", f"\n{value('nose', '1')}"))


def test_names_without_a_prefix_must_differ(folder: Path) -> None:
    put(folder / "arm.xml", camera("Camera0"))
    with pytest.raises(InvalidDocument, match=r"arm.xml:7: component Camera0 is in robot.xml, too"):
        profile(camera("Camera0"), include("arm.xml"))


def test_an_unknown_component_beside_an_include_is_refused(folder: Path) -> None:
    put(folder / "arm.xml", camera("Camera0"))
    wire = WIRE.format("w", "a.Camera0", "a.Camra0")
    with pytest.raises(InvalidDocument, match=r"robot.xml:8: no component a.Camra0 \(did you mean"):
        profile("\n", wire, include("arm.xml", "a."))


def test_a_port_that_only_an_outer_connector_names_is_listed(folder: Path) -> None:
    put(folder / "arm.xml", camera("Camera0"))
    wire = WIRE.format("w", "a.Camera0", "Own0").replace("a.Camera0.image", "a.Camera0.more")
    made = profile(camera("Own0"), wire, include("arm.xml", "a."))
    ports = {each.instance_name: [p.name for p in each.data_ports] for each in made.components}
    assert ports["a.Camera0"] == ["a.Camera0.image", "a.Camera0.more"]


def test_a_prefix_is_before_every_name() -> None:
    composite = (
        camera("Both0")
        .replace('rts:name="noise" rts:data="1"', 'rts:name="members" rts:data="Camera0, Camera1"')
        .replace("Both0.image", "Both0.Camera0.image")
        .replace(
            "</rts:Comp",
            '<rts:Participants><rts:Participant rts:componentId="RTC:Me:test:Camera:1.0"'
            ' rts:instanceName="Camera0"/></rts:Participants>'
            '<rtsExt:Properties rtsExt:name="rtkit.create" rtsExt:value="Both?manager_name=s&amp;'
            'instance_name=Both0&amp;members=Camera0,Camera1&amp;exported_ports=Camera0.image"/>'
            "</rts:Comp",
        )
    )
    states = (
        '<rtsExt:Properties rtsExt:name="rtkit.state.on" rtsExt:value="Camera0=Active; '
        'Camera1.noise=2; *=Inactive"/>'
        '<rtsExt:Properties rtsExt:name="rtkit.event.off" rtsExt:value="lost Camera0"/>'
        '<rtsExt:Properties rtsExt:name="rtkit.restart.slave.s" rtsExt:value="never"/>'
    )
    made = profile(
        camera("Camera0"), camera("Camera1"), composite, WIRE.format("w", "Camera0", "Camera1"),
        states, prefix="a.",
    )  # fmt: skip
    both = made.components[2]
    assert made.id == "RTSystem:Me:a.Robot:1.0"
    assert both.path_uri == "localhost/a.Both0.rtc"
    assert [port.name for port in both.data_ports] == ["a.Both0.a.Camera0.image"]
    assert both.configuration_sets[0].data[0].data == "a.Camera0,a.Camera1"
    assert both.participants[0].instance_name == "a.Camera0"
    assert both.properties[0].value == (
        "Both?manager_name=a.s&instance_name=a.Both0&members=a.Camera0,a.Camera1"
        "&exported_ports=a.Camera0.image"
    )
    assert made.data_port_connectors[0].source.port_name == "a.Camera0.image"
    told = {each.name: each.value for each in made.properties}
    assert told == {
        "rtkit.state.on": "a.Camera0=Active; a.Camera1.noise=2; *=Inactive",
        "rtkit.event.off": "lost a.Camera0",
        "rtkit.restart.slave.a.s": "never",
    }
    assert prefixed(made, "") is made


def test_positions_lead_to_the_file_of_a_part(folder: Path) -> None:
    put(folder / "arm.xml", camera("Camera0"))
    found = read(camera("Own0"), include("arm.xml", "a."))
    assert [Path(each).name for each in found.files] == ["robot.xml", "arm.xml"]
    assert found.position((("components", 0),), "")[:2] == ("robot.xml", 7)
    assert found.position((("components", 1),), "id")[:2] == ("arm.xml", 7)


def test_yaml_takes_the_same(folder: Path) -> None:
    put(folder / "arm.xml", camera("Camera0", "${noise}"), variable("noise", "2"))
    text = """
rtsProfile:
  id: RTSystem:Me:Robot:1.0
  version: '0.2'
  creationDate: 2025-01-01T00:00:00
  updateDate: 2025-01-01T00:00:00
  components:
  - id: RTC:Me:test:Camera:1.0
    pathUri: localhost/Own0.rtc
    instanceName: Own0
    isRequired: true
    "rtkit::if": ${second} == yes
    "rtkit::isRequired": ${needed}
  rtkit::variable:
  - {name: second, default: yes}
  - {name: needed, default: 'false'}
  rtkit::include:
  - file: arm.xml
    prefix: a.
    unless: ${second} == no
    value:
    - {name: noise, value: 7}
"""
    assert has_parameters(text.encode())
    made = read_system(text.encode(), "robot.yaml").profile
    assert [each.instance_name for each in made.components] == ["Own0", "a.Camera0"]
    assert made.components[0].is_required is False
    assert noise(made, "a.Camera0") == "7"
    no = SystemParameters((GivenValue("second", "no", ""),))
    less = read_system(text.encode(), "r.yaml", no).profile
    assert less.components == ()


@pytest.mark.parametrize("prefix", ["a/", "a b", "x:", "a\x01", "\n"])
def test_a_prefix_is_the_beginning_of_a_name(folder: Path, prefix: str) -> None:
    with pytest.raises(UsageProblem, match=r"^--prefix: .* is no beginning of a name"):
        profile(camera("Camera0"), prefix=prefix)
    put(folder / "arm.xml", camera("Camera0"))
    with pytest.raises(InvalidDocument, match=r"^robot.xml:7: 'a/' is no beginning of a name"):
        profile(include("arm.xml", "a/"))


def test_variables_that_grow_without_bound_are_refused() -> None:
    grown = "".join(variable(f"v{n}", f"${{v{n - 1}}}" * 10) for n in range(1, 9))
    with pytest.raises(InvalidDocument, match="becomes longer than 65536 characters"):
        profile(camera("Camera0"), variable("v0", "x" * 10), grown)
    many = "".join(camera(f"Camera{n}", "${v}") for n in range(250))
    with pytest.raises(InvalidDocument, match="texts become longer than"):
        profile(many, variable("v", "x" * 60_000))


def test_includes_that_are_nested_without_bound_are_refused(folder: Path) -> None:
    for number in range(100):
        put(folder / f"{number}.xml", include(f"{number + 1}.xml", "a."))
    put(folder / "100.xml", camera("Camera0"))
    with pytest.raises(InvalidDocument, match="included more than 32 deep"):
        profile(include("0.xml"))
