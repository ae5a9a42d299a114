"""Devices of this host: what is there, what is another one, what changed between looks."""

from __future__ import annotations

from pathlib import Path

from rtkit.link.devices import identity, present
from rtkit.manager.core.events import DevicesSeen
from rtkit.manager.device_watch import DeviceWatch


def test_a_pattern_is_there_while_one_file_fits(tmp_path: Path) -> None:
    pattern = f"{tmp_path}/cam*"
    assert present([pattern, "/dev/null", "/dev/nothing*", "/nowhere/at/all*"]) == ("/dev/null",)
    (tmp_path / "cam9").symlink_to("/nowhere")
    assert not identity(pattern)
    (tmp_path / "cam1").write_text("")
    assert present([pattern]) == (pattern,)


def test_changes_are_told_once_and_another_file_as_gone_and_come(tmp_path: Path) -> None:
    told: list[DevicesSeen] = []
    watch = DeviceWatch(told.append)
    assert watch.look_at is None
    device = tmp_path / "cam"
    bound = {"A": (str(device),), "B": ("/dev/null",)}
    watch.watch(bound)
    assert watch.look_at is not None
    for _ in range(2):
        watch.look()
    assert told == [DevicesSeen((str(device),))]
    device.symlink_to("/dev/null")
    for _ in range(2):
        watch.look()
    assert told[1:] == [DevicesSeen(())]
    other = tmp_path / "other"
    other.symlink_to("/dev/zero")
    other.rename(device)
    watch.look()
    assert told[2:] == [DevicesSeen((str(device),)), DevicesSeen(())]
    watch.watch({})
    assert watch.look_at is None


def test_what_is_absent_is_told_anew_when_components_change(tmp_path: Path) -> None:
    told: list[DevicesSeen] = []
    watch, device = DeviceWatch(told.append), str(tmp_path / "lamp")
    for _ in range(2):
        watch.watch({"A": (device,)})
        watch.look()
        watch.look()
    assert told == [DevicesSeen((device,))] * 2
