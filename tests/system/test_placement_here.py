"""Placement on one host: tags, devices, one process, and what makes no sense."""

from __future__ import annotations

import pytest
from placekit import free_profile
from shells import Shell


def test_tags_of_a_manager_are_those_of_its_host(shell: Shell) -> None:
    file = free_profile(shell.folder / "tag.xml", In1={"tags": "arm,gpu"})
    told = shell.run(f"rtplan {file}")
    assert told.err == "rtplan: no place for In1: localhost: lacks tag arm, gpu\n"
    (shell.folder / "rtc.conf").write_text("rtkit.tags: gpu, arm\n")
    assert "start manager manager" in shell.run(f"rtplan {file}").out
    shell.ok("rtmgr start -o rtkit.tags:gpu")
    assert "lacks tag arm" in shell.run(f"rtplan {file}").err
    shell.ok("rtset /localhost/manager.mgr/settings.rtkit.tags arm,gpu")
    assert shell.run(f"rtapply {file}").status == 0
    assert "rtkit.place.tags" in shell.ok("rtcryo --all")
    shell.ok(f"rtcheck {file}")
    shell.ok("rtset /localhost/manager.mgr/settings.rtkit.tags gpu")
    told = shell.run(f"rtcheck {file}")
    why = "Component /localhost/In1.rtc is not where it may be: lacks tag arm"
    assert (told.status, told.err) == (1, f"{why}\n")
    shell.ok("rtmgr stop")


def test_a_device_decides_and_a_component_that_keeps_without_it_stays(manager: Shell) -> None:
    device = manager.folder / "cam0"
    file = free_profile(manager.folder / "device.xml", In1={"device": f"{manager.folder}/cam?"})
    assert f"no {manager.folder}/cam?" in manager.run(f"rtapply {file}").err
    device.symlink_to("/nowhere")
    assert manager.run(f"rtapply {file}").status == 1
    device.unlink()
    device.symlink_to("/dev/null")
    assert manager.run(f"rtapply {file}").status == 0
    asked = {"device": f"{manager.folder}/cam?", "device_policy": "keep"}
    kept = free_profile(manager.folder / "kept.xml", In1=asked)
    assert "set policy of In1" in manager.ok(f"rtplan {kept}")
    assert manager.run(f"rtapply {kept}").status == 0
    device.unlink()
    assert "nothing to do" in manager.ok(f"rtplan {kept}")
    assert manager.run(f"rtplan {file}").status == 1


def test_a_host_that_is_not_known_is_named(shell: Shell) -> None:
    shell.ok("rthost add robot1 user@192.0.2.1")
    file = free_profile(shell.folder / "typed.xml", In1={"hosts": "localhost,kitchen,robt1"})
    left_out = "warning: In1: rtkit.place.hosts: host {} is not known, and is left out ({})\n"
    near = left_out.format("robt1", "did you mean robot1?")
    far = left_out.format("kitchen", "rthost add kitchen USER@ADDRESS")
    for command in ("rtapply", "rtplan", "rtcheck"):
        told = shell.run(f"{command} {file}")
        assert (told.status, near in told.err, far in told.err) == (0, True, True), told.err
    shell.ok(f"rtteardown --exit {file}")
    file = free_profile(shell.folder / "wrong.xml", In1={"hosts": "kitchen"})
    told = shell.run(f"rtplan {file}")
    assert (told.status, far in told.err) == (1, True)
    shell.ok("rtmgr stop")


def test_components_of_one_process_are_made_in_the_slave_of_one(manager: Shell) -> None:
    file = free_profile(manager.folder / "with.xml", In1={"with": "Out1"}, Out1={})
    text = manager.folder / "with.xml"
    text.write_text(text.read_text().replace('"ConsoleOut"', '"ConsoleOut?manager_name=eyes"'))
    assert manager.run(f"rtapply {file}").status == 0
    assert "In1.rtc" in manager.ok("rtls /localhost/manager.mgr/eyes.mgr")
    assert manager.run(f"rtplan --detailed-exitcode {file}").status == 0


@pytest.mark.parametrize("word", ["rtplan", "rtapply", "rtcheck", "rtstart", "rtprofile check"])
def test_a_requirement_that_makes_no_sense_is_named_with_its_line(
    manager: Shell, word: str
) -> None:
    file = free_profile(manager.folder / "bad.xml", In1={"memory": "lots"}, Out1={"with": "In7"})
    told = manager.run(f"{word} {file}")
    assert told.status == 1
    why = "In1: rtkit.place.memory: not an amount of memory from 1M on, such as 200M or 1.5G: lots"
    assert why in told.err + told.out
    assert "bad.xml:" in told.err + told.out
