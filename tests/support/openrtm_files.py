"""Writes and makes components as authors for OpenRTM-aist-Python do."""

from __future__ import annotations

from pathlib import Path

from openrtm_corpus import COMPONENTS

from rtkit.component.base import Component
from rtkit.modules.loader import Loader
from rtkit.rtc.create import parse_create

EXAMPLES = COMPONENTS / "OpenRTM__OpenRTM-aist-Python" / "OpenRTM_aist" / "examples"
MOTOR = EXAMPLES / "Composite" / "Motor.py"
SENSOR = EXAMPLES / "Composite" / "Sensor.py"

HEAD = """
import OpenRTM_aist
import RTC

spec = ["implementation_id", "{name}", "type_name", "{name}", "description", "A test",
        "version", "1.2", "vendor", "me", "category", "example", "activity_type", "STATIC",
        "max_instance", "1", "language", "Python", "lang_type", "SCRIPT", {more} ""]

class {name}(OpenRTM_aist.DataFlowComponentBase):
{body}

def {name}Init(manager):
    profile = OpenRTM_aist.Properties(defaults_str=spec)
    manager.registerFactory(profile, {name}, OpenRTM_aist.Delete)
"""


def write_component(folder: Path, name: str, body: str, more: str = "", before: str = "") -> Path:
    """Write the module of a component as authors write it; return its file."""
    indented = "\n".join(f"    {line}" for line in body.strip("\n").splitlines())
    file = folder / f"{name}.py"
    file.write_text(before + HEAD.format(name=name, body=indented, more=more), encoding="utf-8")
    return file


def made(file: Path, options: str = "", loader: Loader | None = None) -> Component:
    """Return the initialised component that a file offers."""
    loader = loader or Loader([])
    (type_,) = loader.load(str(file)).types
    component = loader.make(parse_create(f"{type_.type_name}?instance_name=It0{options}"))
    component.initialize()
    return component
