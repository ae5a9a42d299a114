"""What is saved of a running system is sound; what is broken in it is found before it runs."""

from __future__ import annotations

from typing import Any

MANAGER = "/localhost/manager.mgr"
SAMPLES = (
    *("ConfigSample", "ConsoleIn", "ConsoleOut", "Controller", "Doubler", "Microwave"),
    *("MicrowaveKeys", "Motor", "MyServiceConsumer", "MyServiceProvider", "Sensor"),
    *("SeqIn", "SeqOut"),
)


def test_what_is_saved_of_a_running_system_is_sound(manager: Any) -> None:
    manager.ok(f"rtmgr {' '.join(f'-c {name}' for name in SAMPLES)} {MANAGER}")
    service = "MyService{}0.rtc:myservice".format
    manager.ok(f"rtcon /localhost/{service('Consumer')} /localhost/{service('Provider')}")
    manager.ok("rtcon /localhost/ConsoleIn0.rtc:out /localhost/ConsoleOut0.rtc:in")
    manager.ok("rtcon /localhost/Motor0.rtc:pose /localhost/Sensor0.rtc:pose")
    manager.ok(f"rtcomp --add /localhost/Motor0.rtc:pose {MANAGER}:Both")
    manager.ok("rtcryo --all -o all.xml")
    told = "all.xml: valid (system of 14 components, 14 of known type)\n"
    assert manager.run("rtprofile check all.xml") == (0, told, "")
    assert manager.run("rtcheck --static all.xml") == (0, told, "")

    text = (manager.folder / "all.xml").read_text()
    old = 'rts:name="int_param0" rts:data="0"'
    assert old in text
    (manager.folder / "bad.xml").write_text(text.replace(old, old.replace('"0"', '"101"')))
    why = "int_param0 of ConfigSample0 cannot be '101': it is to be 0<=x<=100"
    status, out, err = manager.run("rtprofile check -q bad.xml")
    assert (status, err) == (1, "")
    assert f"error: default.{why} [parameter-constraint] " in out
    told = manager.run("rtconf /localhost/ConfigSample0.rtc set int_param0 101").err
    assert told == f"rtconf: {why.replace(' of ConfigSample0', '')}\n", "it is the same rule"


def test_no_manager_is_needed(shell: Any) -> None:
    assert shell.run("rtcheck --static nix.xml").status == 1
    (shell.folder / "sys.yaml").write_text(
        "rtsProfile: {id: a, components: [{id: 'RTC:rtkit:example:Motor:1.0',"
        " pathUri: localhost/M0.rtc, instanceName: M0}]}\n"
    )
    told = "sys.yaml: valid (system of 1 component, 1 of known type)\n"
    assert shell.run("rtcheck --static sys.yaml") == (0, told, "")
    assert list((shell.folder / "run").iterdir()) == []
