"""Modules are described from their source; none of it runs."""

from __future__ import annotations

import os
import sys
import threading

import pytest

from rtkit.errors import Malformed
from rtkit.manager.query_server import loadable
from rtkit.modules.describing import describe
from rtkit.modules.loader import Loader
from rtkit.resources import resource

MODULE = '''
import os
os.environ["RTKIT_TEST_RAN"] = "1"
from rtkit.component import Component, Parameter
from somewhere import Unknown

COMPANY = "me"
FAST: float = 2.5

class _Base(Unknown):
    """Not this."""
    vendor = COMPANY
    category = "base"
    slow = Parameter(1)

class Arm(_Base, Component):
    """Move
    an arm.

    And more.
    """
    category: str = "Robot"
    version = "1.2"
    rate = 10.0
    speed = Parameter(FAST)
    way = Parameter([1, 2], widget="text")
    odd = Parameter(os.getcwd())
    class_ = Parameter(3)
    gain = Parameter(1.5, name="gainP")

def ArmInit(manager):
    if True:
        manager.register_factory(Arm)
'''


def test_all_that_is_stated_is_understood():
    (offer,) = describe(MODULE.encode(), "/x/Arm.py")
    assert offer.type.id == "RTC:me:Robot:Arm:1.2"
    assert offer.type.description == "Move an arm."
    assert offer.parameters == {"slow": "1", "speed": "2.5", "way": "1,2", "odd": ""} | {
        "class": "3",
        "gainP": "1.5",
    }
    assert "RTKIT_TEST_RAN" not in os.environ


@pytest.mark.parametrize("source", ["", "print(1)", "def main(): pass", "def Init(m): pass"])
def test_what_is_plainly_no_module(source):
    assert describe(source.encode(), "Arm.py") is None


@pytest.mark.parametrize(
    ("source", "why"),
    [
        ("def ArmInit(m:\n", r"SyntaxError: .* \(Arm.py:1\)"),
        ("x.register_factory(Arm)", r"no init function ArmInit \(Arm.py:1\)"),
        ("\ndef ArmInit(m): pass", r"ArmInit registers nothing \(Arm.py:2\)"),
        ("\ndef ArmInit(m): m.register_factory(make())", r"only when it runs \(Arm.py:2\)"),
        ("def ArmInit(m): m.register_factory()", "only when it runs"),
        ("from x import Arm\ndef ArmInit(m):\n m.register_factory(Arm)", r"not defined .*:3\)"),
        ("ArmInit = 1 + \0", "null bytes"),
    ],
)
def test_what_cannot_be_described_has_a_reason(source, why):
    with pytest.raises(Malformed, match=why):
        describe(source.encode(), "Arm.py")


@pytest.mark.parametrize(
    "head",
    ["(" * 100_000, "-" * 200_000 + "1", "1+" * 100_000 + "1", "not " * 100_000 + "1"],
)
def test_deep_sources_do_not_end_the_process(head):
    told = []

    def read():
        with pytest.raises(Malformed) as caught:
            describe(f"{head}\ndef ArmInit(m): m.register_factory(A)".encode(), "Arm.py")
        told.append(str(caught.value))

    thread = threading.Thread(target=read)
    thread.start()
    thread.join()
    assert len(told) == 1


def test_a_circle_of_bases_ends():
    source = "class A(B): vendor='x'\nclass B(A): pass\ndef AInit(m): m.register_factory(A)"
    (offer,) = describe(source.encode(), "A.py")
    assert offer.type.vendor == "x"


def test_the_samples_are_read_as_they_are_when_loaded():
    folder = resource("examples", "basic")
    loader = Loader([folder])
    names = [name for name in sorted(os.listdir(folder)) if name.endswith(".py")]
    for name in names:
        with open(os.path.join(folder, name), "rb") as file:
            offers = describe(file.read(), name)
        assert offers is not None, name
        assert [offer.type for offer in offers] == list(loader.load(name).types), name


def test_the_lines_of_a_scan(tmp_path):
    one, two = tmp_path / "one", tmp_path / "two"
    one.mkdir()
    two.mkdir()
    (one / "Arm.py").write_text(MODULE)
    (two / "Arm.py").write_text("hidden behind the one before")
    (one / "script.py").write_text("print('no module')")
    (one / "Open.py").write_text(MODULE)
    (one / "Open.py").chmod(0o666)
    (two / "Away.py").symlink_to("/etc/hostname")
    (two / "Broken.py").write_text("def BrokenInit(")
    before = set(sys.modules)
    lines = loadable([str(one), str(two), str(tmp_path / "absent")]).splitlines()
    assert set(sys.modules) == before
    lines = [line for line in lines if "RTC:rtkit:service:" not in line]  # those of rtkit itself
    assert [line.partition("?")[0] for line in lines] == [
        "RTC:me:Robot:Arm:Python:1.2",
        "Open.py",
        "Away.py",
        "Broken.py",
    ]
    assert lines[0].endswith(
        f"&module={one}/Arm.py&conf.default.slow=1&conf.default.speed=2.5&conf.default.way=1,2"
        "&conf.default.class=3&conf.default.gainP=1.5"
    )
    assert "written by everybody" in lines[1]
    assert "leaves the load path" in lines[2]
    assert "SyntaxError" in lines[3]


def test_several_names_in_one_assignment() -> None:
    source = b"""
class Arm(Component):
    vendor, category, version = "acme", "test", "1.0"
    a = b, c = "x", "y"


def ArmInit(manager):
    manager.register_factory(Arm)
"""
    offers = describe(source, "Arm.py")
    assert offers is not None
    assert offers[0].type.full_id == "RTC:acme:test:Arm:Python:1.0"


SERVICE = '''
from elsewhere import Away
from rtkit import init_of

class Lamp:
    """Shine."""
    version = "2.0"

LampInit = init_of(Lamp, category="home")
AwayInit = rtkit.init_of(Away)
OddInit = init_of(make())
'''


def test_a_served_class_is_offered_as_a_service():
    (lamp,) = describe(SERVICE.encode(), "/x/Lamp.py")
    (away,) = describe(SERVICE.encode(), "/x/y.py", "AwayInit", "house.lights")
    assert (lamp.type.id, lamp.type.description) == ("RTC::home:Lamp:2.0", "Shine.")
    assert away.type.id == "RTC:house:service:Away:1.0"
    with pytest.raises(Malformed, match=r"known only when it runs \(/x/y.py:11\)"):
        describe(SERVICE.encode(), "/x/y.py", "OddInit")
