"""Pairs of components with scripts that connect them, as in the tutorial of OpenRTM-aist."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from openrtm_samples import CONNECTOR, TICKER, write_pair
from waiting import until

PLACE = "/localhost/manager.mgr"
Start = Callable[..., "subprocess.Popen[str]"]


@pytest.fixture
def start(shell: Any) -> Iterator[Start]:
    """Return a function that runs a file as a script, with pipes to all its streams."""
    started: list[subprocess.Popen[str]] = []

    def run(file: Path, *arguments: str) -> subprocess.Popen[str]:
        command = [str(Path(sys.executable).with_name("rtkit")), "openrtm", "run", str(file)]
        pipe = subprocess.PIPE
        started.append(
            subprocess.Popen(
                [*command, *arguments],
                stdin=pipe,
                stdout=pipe,
                stderr=pipe,
                text=True,
                env=shell.environment,
                cwd=shell.folder,
            )
        )
        return started[-1]

    yield run
    for each in started:
        each.kill()
        each.communicate()


def line_of(process: subprocess.Popen[str]) -> str:
    assert process.stdout is not None
    return process.stdout.readline().strip()


def type_in(process: subprocess.Popen[str], text: str) -> None:
    assert process.stdin is not None
    process.stdin.write(text)
    process.stdin.flush()


def script(folder: Path, name: str, text: str) -> Path:
    file = folder / f"{name}.py"
    file.write_text(text)
    return file


def test_two_scripts_are_connected_by_a_third(shell: Any, start: Start, tmp_path: Path) -> None:
    source_file, sink_file = write_pair(tmp_path)
    source, sink = start(source_file), start(sink_file)
    connector = start(script(tmp_path, "Connector", CONNECTOR))
    out, err = connector.communicate(timeout=30)
    assert (connector.returncode, err) == (0, "")
    assert out.splitlines() == [
        "RTC_OK ['connector0']",
        "INACTIVE_STATE RTC_OK ACTIVE_STATE PERIODIC",
        "INACTIVE_STATE RTC_OK ACTIVE_STATE PERIODIC",
    ]
    type_in(source, "21\n42\n")
    assert [line_of(sink), line_of(sink)] == ["Received: 21", "Received: 42"]
    type_in(source, "-1\n")  # it ends itself
    assert source.wait(20) == 0
    assert "In0" not in shell.ok("rtls /localhost")


def test_a_script_ticks_two_others(shell: Any, start: Start, tmp_path: Path) -> None:
    kind = ("-o", "exec_cxt.periodic.type: ExtTrigExecutionContext")
    source_file, sink_file = write_pair(tmp_path)
    source, sink = start(source_file, *kind), start(sink_file, *kind)
    ticker = start(script(tmp_path, "Ticker", TICKER))
    assert [line_of(ticker) for _ in range(3)] == [
        "RTC_OK ['connector0']",
        "INACTIVE_STATE RTC_OK ACTIVE_STATE OTHER",
        "INACTIVE_STATE RTC_OK ACTIVE_STATE OTHER",
    ]
    type_in(ticker, "0\n")  # comes back before the cycle is over, which waits for a number
    assert line_of(ticker) == "RTC_OK"
    type_in(source, "21\n")
    assert line_of(source) == "Please input number: Sent 21"
    type_in(ticker, "1\n")
    assert line_of(sink) == "Received: 21"


def test_a_script_preloads_modules_and_makes_a_composite_of_them(
    shell: Any, start: Start, tmp_path: Path
) -> None:
    write_pair(tmp_path)
    whole = "composite.PeriodicECShared.PeriodicECSharedComposite0.config_file"
    conf = tmp_path / "whole.conf"
    conf.write_text("conf.default.members: In0, Out0\nconf.default.exported_ports: Out0.in\n")
    rtc_conf = tmp_path / "my.conf"
    rtc_conf.write_text(
        f"manager.modules.load_path: {tmp_path}\n"
        "manager.modules.preload: In, Out\n"
        "manager.components.precreate: In, Out, PeriodicECSharedComposite\n"
        f"{whole}: {conf}\n"
    )
    text = (
        "import sys\nimport OpenRTM_aist\n"
        "manager = OpenRTM_aist.Manager.init(sys.argv)\n"
        "manager.activateManager()\n"
        "print([each.path for each in manager.getComponents()[2:]], flush=True)\n"
        "manager.runManager()\n"
    )
    process = start(script(tmp_path, "Whole", text), "-f", str(rtc_conf))
    assert line_of(process) == "['/localhost/PeriodicECSharedComposite0.rtc']"
    shell.ok("rtact /localhost/PeriodicECSharedComposite0.rtc")
    assert "Active" in shell.ok("rtls -l /localhost/Out0.rtc")
    assert shell.run("rtinject -c 21 /localhost/PeriodicECSharedComposite0.rtc:Out0.in").status == 0
    assert process.poll() is None


def test_a_component_of_a_manager_ends_itself(manager: Any, tmp_path: Path) -> None:
    file, _ = write_pair(tmp_path)
    for place in ("", "&manager_name=slave"):
        manager.ok(f"rtmgr -l {file}:InInit -c 'In?instance_name=In0{place}' {PLACE}")
        manager.ok("rtact /localhost/In0.rtc")
        manager.ok("rtattach --send -1 -t 20 /localhost/In0.rtc")
        until(lambda: "In0" not in manager.ok("rtls -l /localhost"), "it is gone")


LOOKER = """
import sys

from omniORB import CORBA, any

import CosNaming
import OpenRTM_aist
import RTC

orb = CORBA.ORB_init(sys.argv, CORBA.ORB_ID)
names = orb.resolve_initial_references("NameService")._narrow(CosNaming.NamingContext)
for each in names.list(100)[0]:
    print(each.binding_name[0].id, each.binding_name[0].kind, each.binding_type)
found = names.resolve([CosNaming.NameComponent("ConsoleOut0", "rtc")])._narrow(RTC.RTObject)
print(found.get_component_profile().type_name, found.get_ports()[0].get_port_profile().name)
try:
    names.resolve([CosNaming.NameComponent("Nobody0", "rtc")])
except CosNaming.NamingContext.NotFound as error:
    print("not found", error.rest_of_name[0].id)
context = found.get_owned_contexts()[0]
print(context.set_rate(50), context.get_rate())
print(found.exit(), found._non_existent())
"""


def test_a_script_looks_at_native_components(manager: Any, start: Start, tmp_path: Path) -> None:
    manager.ok(f"rtmgr -c ConsoleOut {PLACE}")
    out, err = start(script(tmp_path, "Looker", LOOKER)).communicate(timeout=30)
    assert err == ""
    assert out.splitlines() == [
        "ConsoleOut0 rtc nobject",
        "manager mgr ncontext",
        "ConsoleOut ConsoleOut0.in",
        "not found Nobody0",
        "RTC_OK 50.0",
        "RTC_OK True",
    ]
