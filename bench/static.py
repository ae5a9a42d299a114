"""Measures static checks of systems against a bare parse of the same documents."""

from __future__ import annotations

import os
import re
import sys
import tempfile

from bench.harness import Lines, Row, command, process
from bench.pairs import paired
from rtkit.resources import resource

COMPONENTS = 1000
TYPES = 33
_PARTS = ("Controller", "Motor", "Sensor")
_FLOOR_IS = "python -c: import lxml, parse the system and the profiles of its types"
_FLOOR = """
import glob
from lxml import etree
for file in ["{system}", *glob.glob("{folder}/*.xml")]:
    with open(file, "rb") as stream:
        etree.fromstring(stream.read())
"""


def _check() -> Lines:
    with tempfile.TemporaryDirectory(prefix="rtb") as base:
        system, folder = os.path.join(base, "system.xml"), os.path.join(base, "parts")
        os.mkdir(folder)
        _write(system, _system())
        for name in _PARTS:
            for number in range(TYPES):
                _write(os.path.join(folder, f"{name}{number}.xml"), _profile(name, number))
        ours = [command("rtprofile"), "check", system, "--components", folder]
        floor = [sys.executable, "-c", _FLOOR.format(system=system, folder=folder)]
        measured = paired(lambda: process(ours), lambda: process(floor), 7)
        what = f"check of {COMPONENTS:,} components of {TYPES * len(_PARTS)} types, whole process"
        yield Row(what, "ms", measured, 1000.0, False, _FLOOR_IS)


PARTS = {"check": _check}


def _write(path: str, text: str) -> None:
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def _read(*parts: str) -> str:
    with open(resource("profiles", *parts), encoding="utf-8") as file:
        return file.read()


def _profile(name: str, number: int) -> str:
    return (
        _read(f"{name}.xml")
        .replace(f"{name}:1.0", f"{name}{number}:1.0")
        .replace(f'rtc:name="{name}"', f'rtc:name="{name}{number}"')
    )


def _system() -> str:
    """Return as many robots of three components as make a thousand, and one component more."""
    text = _read("systems", "sensor-controller-motor.xml")
    head = text[: text.index("    <rts:Components")]
    components = re.findall(r"    <rts:Components.*?</rts:Components>\n", text, re.DOTALL)
    connectors = re.findall(r"    <rts:DataPortC.*?</rts:DataPortConnectors>\n", text, re.DOTALL)
    robots, more = divmod(COMPONENTS, len(_PARTS))
    made = [_renamed(part, number) for number in range(robots) for part in components]
    made += [_renamed(part, robots) for part in components[:more]]
    made += [_renamed(wire, number) for number in range(robots) for wire in connectors]
    return head + "".join(made) + "</rts:RtsProfile>\n"


def _renamed(text: str, number: int) -> str:
    for name in _PARTS:
        text = text.replace(f"{name}0", f"{name}-{number}")
        text = text.replace(f"{name}:1.0", f"{name}{number % TYPES}:1.0")
    return text
