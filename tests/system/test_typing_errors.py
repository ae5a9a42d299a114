"""Thirty typing errors, of each kind of name: the message names what was meant."""

from __future__ import annotations

import re
from typing import Any

from rtkit.resources import resource

KEEPS_MANAGER = True
SYSTEM = resource("profiles", "systems", "sensor-controller-motor.xml")
MANAGER = "/localhost/manager.mgr"
PORT = "/localhost/ConsoleIn0.rtc:out /localhost/ConsoleOut0.rtc:in"
LEAST = 27
ERRORS = (
    ("rtkit lss", "ls"),
    ("rtkit conect", "con"),
    ("rtkit resurect", "resurrect"),
    ("rtkit help conectors", "connectors"),
    ("rtls --recurze", "--recurse"),
    ("rtcon --no-duplicate", "--no-duplicates"),
    ("rtls /localhost/ConsolIn0.rtc", "ConsoleIn0.rtc"),
    ("rtcat /localhost/consoleout0.rtc", "ConsoleOut0.rtc"),
    ("rtact /localhost/ConfigSmaple0.rtc", "ConfigSample0.rtc"),
    ("rtcat /localhost/ConsoleIn0.rtc:ot", "out"),
    ("rtcon /localhost/ConsoleIn0.rtc:outt /localhost/ConsoleOut0.rtc:in", "out"),
    ("rtprint /localhost/ConsoleIn0.rtc:oot", "out"),
    ("rtconf /localhost/ConfigSample0.rtc set int_parm0 3", "int_param0"),
    ("rtconf /localhost/ConfigSample0.rtc -s defualt act", "default"),
    ("rtconf /localhost/ConfigSample0.rtc sett int_param0 3", "set"),
    (f"rtmgr -c ConsolIn {MANAGER}", "ConsoleIn"),
    (f"rtmgr -l ConsolOut.py:ConsoleOutInit {MANAGER}", "ConsoleOut"),
    (f"rtmgr -d ConsolOut0 {MANAGER}", "ConsoleOut0"),
    (f"rtmgr -c 'ConsoleIn?instnce_name=A' --strict {MANAGER}", "instance_name"),
    (f"rtmgr -s manager.modules.load_pat=x --strict {MANAGER}", "manager.modules.load_path"),
    ("rtmgr strat", "start"),
    ("rtmgr stop managr", "manager"),
    (
        f"rtcon --strict -p dataport.publisher.push_polcy=new {PORT}",
        "dataport.publisher.push_policy",
    ),
    (f"rtcon -p dataport.dataflow_type=psuh {PORT}", "push"),
    (f"rtcon -p dataport.publisher.push_policy=neww {PORT}", "new"),
    ("rtprofile validat x.xml", "validate"),
    (f"rtprofile set {SYSTEM} Motr0:gain=3", "Motor0"),
    ("rtwait /localhost/ConsoleIn0.rtc actve", "active"),
    ("rtvlog --level wran", "WARN"),
    ("rtget /localhost/ConsoleIn0.rtc.stat", "state"),
)


def test_the_right_guess_comes_first(manager: Any) -> None:
    manager.ok(f"rtmgr -c ConsoleIn -c ConsoleOut -c ConfigSample {MANAGER}")
    wrong = []
    for line, meant in ERRORS:
        done = manager.run(line)
        guess = re.search(r"[Dd]id you mean '?(.*?)'?(?: or .*)?\?", done.err)
        if done.status == 0 or guess is None or guess[1].rpartition("/")[2] != meant:
            wrong.append((line, done.err))
    assert len(ERRORS) - len(wrong) >= LEAST, wrong
