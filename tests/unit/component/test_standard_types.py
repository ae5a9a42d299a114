"""The data types of the standard: found by name, imported when asked for, laid out as the IDL."""

from __future__ import annotations

import ast
import pickle
import pydoc
import runpy
import subprocess
import sys
from dataclasses import fields, is_dataclass
from enum import Enum
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from typing import get_type_hints

import pytest

import rtkit.component as component
from rtkit.component.standard import FAMILIES, SCOPES, home_of, names_of
from rtkit.component.values.codec import codec_for
from rtkit.component.values.type_layout import layout_of
from rtkit.component.values.typenames import type_by_name, type_name
from rtkit.errors import Malformed

ROOT = Path(__file__).parents[3]
EVERY = [(scope, name, home_of(scope, name)) for scope in SCOPES for name in names_of(scope)]


@pytest.mark.parametrize(("scope", "name", "home"), EVERY)
def test_each_type_is_where_the_table_says_and_known_by_its_name(scope, name, home):
    cls = getattr(import_module(f"rtkit.component.{home}"), name)
    if is_dataclass(cls):
        assert type_by_name(f"IDL:{scope}/{name}:1.0") is cls
        assert type_name(cls) == f"IDL:{scope}/{name}:1.0"
    if scope == "RTC":
        assert getattr(component, name) is cls


@pytest.mark.parametrize("family", FAMILIES)
def test_the_classes_are_what_the_stubs_say(family):
    """The stubs come from the reader of any IDL: the files keep to the form that is read here."""
    module = import_module(f"rtkit.component.{family}")
    names = {name: getattr(component, name) for name in component.__all__}
    names |= {name: getattr(module, name) for name in module.__all__} | vars(module)
    stub = ast.parse((ROOT / "rtkit" / "component" / f"{family}.pyi").read_text())
    classes = {each.name: each for each in stub.body if isinstance(each, ast.ClassDef)}
    others = {each.targets[0].id: each.value for each in stub.body if isinstance(each, ast.Assign)}
    assert {*classes, *others} == {*module.__all__}
    for name, value in others.items():
        assert eval(ast.unparse(value), names) == getattr(module, name)
    for name, node in classes.items():
        cls = getattr(module, name)
        assert cls.__doc__ == ast.get_docstring(node)
        if issubclass(cls, Enum):
            told = {each.targets[0].id: each.value.value for each in node.body[1:]}
            assert {each.name: each.value for each in cls} == told
        else:
            told = {
                each.target.id: eval(ast.unparse(each.annotation), names) for each in node.body[1:]
            }
            assert get_type_hints(cls, include_extras=True) == told
            assert list(told) == [each.name for each in fields(cls)]


@pytest.mark.parametrize("home", FAMILIES)
def test_modules_of_types_look_like_any_module(home):
    module = import_module(f"rtkit.component.{home}")
    assert {*module.__all__} <= {*dir(module)}
    taken: dict[str, object] = {}
    exec(f"from rtkit.component.{home} import *", taken)
    assert {*module.__all__} <= {*taken}
    with pytest.raises(AttributeError, match="no attribute 'Unheard'"):
        _ = module.Unheard


def test_values_are_pickled_and_classes_explained():
    value = component.TimedLong(data=4)
    assert pickle.loads(pickle.dumps(value)) == value
    assert "A 32 bit integer" in pydoc.render_doc(component.TimedLong)


def test_the_package_lists_what_it_has():
    taken: dict[str, object] = {}
    exec("from rtkit.component import *", taken)
    assert {"Component", "TimedLong", "RangeData", "Polarity"} <= {*taken}
    with pytest.raises(AttributeError, match="no attribute 'Unheard'"):
        _ = component.Unheard


def test_threads_get_one_class_for_one_type():
    code = """if True:
        import sys, threading
        sys.setswitchinterval(1e-6)
        from rtkit.component import images
        begun, found = threading.Barrier(8), []
        def ask():
            begun.wait()
            found.append([getattr(images, each) for each in images.__all__])
        threads = [threading.Thread(target=ask) for _ in range(8)]
        for each in threads: each.start()
        for each in threads: each.join()
        assert len(found) == 8 and len({*map(tuple, found)}) == 1, found
    """
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_type_is_made_when_it_is_asked_for():
    code = "from rtkit.component import timed; timed.TimedLong; print(*vars(timed))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "TimedLong" in done.stdout.split()
    assert "TimedShort" not in done.stdout.split()


def test_the_stubs_are_what_the_interface_definitions_make(tmp_path):
    """Change rtkit/component/idl, then run tools/make_standard_types.py."""
    runpy.run_path(str(ROOT / "tools" / "make_standard_types.py"))["write"](tmp_path)
    made = sorted(tmp_path.iterdir())
    assert len(made) == 7
    for file in made:
        assert file.read_text() == (ROOT / "rtkit" / "component" / file.name).read_text(), file.name


def test_fields_defaults_and_bytes_stay_what_they_are_on_the_wire():
    """Values of an earlier rtkit, or of a recording, have to be read by the next one."""
    told = []
    for scope, name, _ in EVERY:
        cls = type_by_name(f"{scope}::{name}")
        if issubclass(cls, Enum):
            told.append(f"{scope}::{name} {[(each.name, each.value) for each in cls]}")
        else:
            names = [field.name for field in fields(cls)]
            told.append(f"{scope}::{name} {names} {cls()} {codec_for(cls).encode(cls()).hex()}")
    digest = sha256("\n".join(sorted(told)).encode()).hexdigest()
    assert digest == "2a4936872031eb62b29a4e3ae86de9041a3e7ebcc27e326961d2dd5073a79a42"


def test_a_name_without_module_is_the_one_of_module_rtc():
    assert type_by_name("CameraImage").__module__ == "rtkit.component.sensors"
    assert type_by_name("Img::CameraImage").__module__ == "rtkit.component.images"
    assert type_by_name("TimedCameraImage").__module__ == "rtkit.component.images"
    assert type_by_name("Other::CameraImage") is None
    assert type_by_name("RTC::TimedCameraImage") is None


# As the interface definitions have them, written down here independently of the classes.
IDL = {
    "RTC::RangeData": "tm ranges geometry config",
    "RTC::RangerConfig": "minAngle maxAngle angularRes minRange maxRange rangeRes frequency",
    "RTC::CameraImage": "tm width height bpp format fDiv pixels",
    "RTC::CameraInfo": "focalLength principalPoint k1 k2 p1 p2",
    "RTC::GPSData": "tm timeFromGPS latitude longitude altitude horizontalError verticalError"
    " heading horizontalSpeed verticalSpeed numSatellites fixType",
    "RTC::INSData": "tm latitude longitude altitude heightAMSL velocityENU orientation",
    "RTC::Covariance3D": "xx xy xz xr xp xa yy yz yr yp ya zz zr zp za rr rp ra pp pa aa",
    "RTC::Actuator": "position speed accel current status",
    "RTC::ActArrayActuatorGeometry": "type length orientation axis minRange centre maxRange"
    " homePosition hasBrakes",
    "RTC::LineFeature": "probability rho alpha covariance start end startSighted endSighted",
    "RTC::Waypoint2D": "target distanceTolerance headingTolerance timeLimit maxSpeed",
    "RTC::Fiducials": "tm fiducialsList",
    "RTC::OGMapTile": "column row width height cells",
    "Img::TimedCameraImage": "tm data error_code",
    "Img::CameraImage": "captured_time image intrinsic extrinsic",
    "Img::ImageData": "width height format raw_data",
}


@pytest.mark.parametrize("name", IDL)
def test_fields_and_their_order(name):
    assert [field.name for field in fields(type_by_name(name))] == IDL[name].split()


def test_bytes_of_a_camera_image():
    image = component.CameraImage(component.Time(1, 2), 3, 4, 24, "bgr", 0.5, b"\x01\x02")
    assert codec_for(component.CameraImage).encode(image).hex() == (
        "00010000"  # header
        "01000000"
        "02000000"  # tm
        "0300"
        "0400"
        "1800"
        "0000"  # width, height, bpp, padding
        "04000000"
        "62677200"  # format
        "000000000000e03f"  # fDiv
        "02000000"
        "0102"  # pixels
    )


def test_color_formats_have_the_numbers_of_the_idl():
    formats = list(import_module("rtkit.component.images").ColorFormat)
    numbers = {one.name: one.value for one in formats}
    assert [numbers[name] for name in ("CF_RGB", "CF_JPEG", "RGB", "GREY", "V422", "Y16")] == [
        1, 3, 5, 14, 24, 36,
    ]  # fmt: skip


@pytest.mark.parametrize("bad", ["", "ab", "\U0001f600", "\ud800", 7])
def test_a_wide_character_is_one_unit_that_stands_for_itself(bad):
    codec = codec_for(component.TimedWChar)
    with pytest.raises(Malformed, match="data"):
        codec.encode(component.TimedWChar(component.Time(), bad))


def test_half_of_a_surrogate_pair_is_not_read():
    codec = codec_for(component.TimedWChar)
    sound = codec.encode(component.TimedWChar(component.Time(), "\u9577"))
    assert sound[12:] == b"\x77\x95"
    with pytest.raises(Malformed, match="surrogate"):
        codec.decode(sound[:12] + b"\x00\xd8")


def test_families_are_imported_only_when_asked_for():
    code = (
        "import sys, rtkit.component as c; c.InPort; c.TimedLong;"
        "loaded = [m for m in sys.modules if m.startswith('rtkit.component.')];"
        "c.RangeData;"
        "print(*sorted({m.rpartition('.')[2] for m in sys.modules} - {''}), '|', *loaded)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    after, _, before = done.stdout.partition("|")
    assert "sensors" in after.split()
    assert "actuators" not in after.split()
    families = ("geometry", "extended", "sensors", "actuators", "navigation", "images")
    assert not [name for name in before.split() if name.rpartition(".")[2] in families]


def test_every_layout_can_be_read():
    for scope, name, _ in EVERY:
        cls = type_by_name(f"{scope}::{name}") if name not in ENUMS else None
        if cls is not None:
            assert layout_of(cls).name == name


ENUMS = {
    "ActArrayActuatorStatus",
    "ActArrayActuatorType",
    "ColorFormat",
    "GPSFixType",
    "GripperStatus",
    "LimbStatus",
}
