"""Generated components in real processes: their own tests, and what a user does with them."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from corpus import CORPUS, ROOT, needs_corpus

IDL = ROOT / "tests" / "idl"
SPREAD = {
    "ConsoleSeqIn": "BaronYSYong__openrtm-tutorial__ConsoleSeqIn_cpp__RTC.xml",
    "joker2": "Mr-akami__CameraRGBColorSensor-RTCS__RTC.xml",
    "Crawl_Gait_Controller": "Nobu19800__Crawl_Gait_Controller__RTC.xml",
    "XXX": "OpenRTM__OpenRTP-aist__jp.go.aist.rtm.rtcbuilder__resource__100__TestComp__XXX__"
    "RTC.xml",
    "ProcessingExample": "OpenRTM__OpenRTP-aist__jp.go.aist.rtm.rtcbuilder.processing__resource__"
    "ProcessingExample2.xml",
    "ModuleName": "OpenRTM__OpenRTP-aist__jp.go.aist.rtm.rtcbuilder.python__resource__FSM__"
    "eventType__RTC.xml",
    "ActArray": "OpenRTM__OpenRTM-aist__examples__Templates__ActArray.xml",
    "RTC_CO2_K30": "KentaTohashi__RTC_K30__RTC.xml",
    "GreaterF": "OpenRTM__OpenRTP-aist__jp.go.aist.rtm.toolscommon.profiles__resource__RTC__"
    "Constraint__GreaterF.xml",
}
MANAGER = "/localhost/manager.mgr"

pytestmark = needs_corpus


def build(shell: Any, name: str, options: str = "") -> Path:
    shutil.copy(CORPUS / "rtc" / SPREAD[name], shell.folder / f"{name}.xml")
    outcome = shell.run(f"rtbuild {name}.xml -o {name} -I '{IDL}' {options}")
    assert outcome.status == 0, outcome.err
    folder: Path = shell.folder / name
    return folder


@pytest.mark.parametrize("name", SPREAD)
def test_it_passes_its_own_test(shell: Any, name: str) -> None:
    folder = build(shell, name)
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-W", "error", "-p", "no:cacheprovider"],
        cwd=folder,
        env=shell.environment,
        capture_output=True,
        text=True,
        timeout=50,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "test_a_manager_runs_it" in (folder / "tests" / f"test_{name}.py").read_text()


@pytest.mark.parametrize("name", ["ConsoleSeqIn", "XXX", "ModuleName", "ActArray"])
def test_it_is_connected_with_its_mirror(shell: Any, name: str) -> None:
    folder = build(shell, name, "--mirror")
    linted = [sys.executable, "-m", "ruff", "check", "--no-cache", "."]
    subprocess.run(linted, cwd=folder, check=True)
    shell.folder = folder
    shell.ok("rtmgr start")
    shell.ok("rtresurrect mirror.xml")
    shell.ok(f"rtact /localhost/{name}0.rtc /localhost/{name}Mirror0.rtc")
    shell.ok("rtcheck mirror.xml")
    told = ElementTree.parse(folder / "mirror.xml").getroot()
    ports = [each.tag.rpartition("}")[2] for each in told.iter()]
    wires = ports.count("DataPortConnectors") + ports.count("ServicePortConnectors")
    own = shell.ok(f"rtcat -l /localhost/{name}0.rtc").splitlines()
    assert sum("Connected to" in line for line in own) == wires > 0


def test_three_of_them_work_together(manager: Any) -> None:
    """As a new user: build, fill in, load, create, connect, activate, look."""
    provider = build(manager, "XXX") / "XXX.py"
    fill(provider, {"get_value": "return 2.5", "set_value": "pass", "echo": "return msg"})
    code = provider.read_text()
    assert build(manager, "XXX") == provider.parent
    assert provider.read_text() == code
    for name in ("ConsoleSeqIn", "ModuleName", "XXX"):
        file = build(manager, name) / f"{name}.py"
        manager.ok(f"rtmgr -l {file}:{name}Init -c '{name}?manager_name=s{name}' {MANAGER}")
        manager.ok(f"rtact /localhost/{name}0.rtc")
    listed = manager.ok("rtls -l /localhost").splitlines()
    assert [line.split()[0] for line in listed if ".rtc" in line] == ["Active"] * 3
    assert "VenderName" in manager.ok("rtcat /localhost/ModuleName0.rtc")
    assert manager.ok("rtfsm /localhost/ModuleName0.rtc getstate") == "State01\n"
    assert "SimpleService::MyService" in manager.ok("rtcat -ll /localhost/XXX0.rtc")
    manager.ok(f"rtmgr -c ConsoleIn {MANAGER}")
    manager.ok("rtcon /localhost/ConsoleIn0.rtc:out /localhost/XXX0.rtc:in")
    manager.ok("rtact /localhost/ConsoleIn0.rtc")
    assert "Connected to" in manager.ok("rtcat -l /localhost/XXX0.rtc:in")


def test_services_of_generated_components_are_called_across_processes(manager: Any) -> None:
    provider = build(manager, "XXX") / "XXX.py"
    consumer = build(manager, "ProcessingExample") / "ProcessingExample.py"
    fill(provider, {"echo": "return msg.upper()", "set_value": "self.value = value"})
    fill(provider, {"get_value": "return 2 * self.value"})
    text = consumer.read_text()
    mark = "# <user code on_activated>\n"
    body = (
        "        service = self.my_service.client\n"
        "        service.set_value(2.5)\n"
        "        self.logger.info('%s %s', service.echo('abc'), service.get_value())\n"
    )
    assert mark in text
    consumer.write_text(text.replace(mark, mark + body))
    for file in (provider, consumer):
        name = file.stem
        manager.ok(f"rtmgr -l {file}:{name}Init -c '{name}?manager_name=s{name}' {MANAGER}")
    manager.ok("rtcon /localhost/ProcessingExample0.rtc:MyService /localhost/XXX0.rtc:MyServide")
    manager.ok("rtact /localhost/XXX0.rtc /localhost/ProcessingExample0.rtc")
    assert '"message": "ABC 5.0"' in manager.log()


def fill(file: Path, bodies: dict[str, str]) -> None:
    """Write users' code where the generator left room for it."""
    text = file.read_text()
    for name, body in bodies.items():
        empty = f".{name}>\n        raise NotImplementedError"
        assert empty in text, name
        text = text.replace(empty, f".{name}>\n        {body}")
    file.write_text(text)


def test_the_sample_system_can_be_brought_up(manager: Any) -> None:
    folder = build(manager, "RTC_CO2_K30")
    (manager.modules / "RTC_CO2_K30.py").write_bytes((folder / "RTC_CO2_K30.py").read_bytes())
    manager.ok(f"rtresurrect {folder}/system.xml")
    assert manager.run(f"rtstart {folder}/system.xml").status == 0
    manager.ok(f"rtcheck {folder}/system.xml")
    assert "Active" in manager.ok("rtls -l /localhost/RTC_CO2_K300.rtc")


def test_what_a_project_imports_lies_beside_it(manager: Any) -> None:
    folder = build(manager, "XXX")
    names = sorted(os.listdir(folder))
    assert {"XXX.py", "XXX_idl.py", "idl", "tests", "system.xml", "pyproject.toml"} <= set(names)
    manager.ok(f"rtmgr -l {folder}/XXX.py:XXXInit -c 'XXX?manager_name=a' -c XXX {MANAGER}")
    assert manager.ok("rtls /localhost").split()[:2] == ["XXX0.rtc", "XXX1.rtc"]
