"""``--strict``: what is not known is refused, and nothing of it stays; else it is told."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

KEEPS_MANAGER = True
MANAGER = "/localhost/manager.mgr"
ODD = """from rtkit.component import Component


class Odd(Component):
    def on_exectue(self):
        pass


def OddInit(manager):
    manager.register_factory(Odd)
"""
NO_CALLBACK = "Odd.on_exectue is no callback (did you mean on_execute?)"
PERIOD = "unknown option: exec_cxt.periodc.rate (did you mean exec_cxt.periodic.rate?)"
VAIN = "timer.tick has no effect: nothing is polled"


@pytest.mark.parametrize(
    ("line", "failed", "why"),
    [
        ("rtmgr {m} -l ./Odd.py:OddInit", "load module: ./Odd.py:OddInit", NO_CALLBACK),
        (
            "rtmgr {m} -c 'ConsoleIn?conf.default.x=1&manager_name=s'",
            "create component: ConsoleIn?conf.default.x=1&manager_name=s",
            "ConsoleIn0 has no parameter x: conf.default.x",
        ),
        (
            "rtcomp {m} -o exec_cxt.periodc.rate=3",
            "create component: PeriodicECSharedComposite?exec_cxt.periodc.rate=3"
            "&instance_name=CompositeRTC",
            PERIOD,
        ),
    ],
)
def test_what_would_be_made_with_a_note_is_not(
    manager: Any, line: str, failed: str, why: str
) -> None:
    (manager.folder / "Odd.py").write_text(ODD)
    typed = line.format(m=MANAGER)
    name = typed.split()[0]
    before = manager.ok("rtls -R")
    assert manager.run(f"{typed} --strict") == (1, "", f"{name}: Failed to {failed} ({why})\n")
    assert manager.ok("rtls -R") == before
    assert manager.run(typed) == (0, "", f"{name}: note: {why}\n")


def test_what_has_no_effect_is_not_set(manager: Any) -> None:
    for line in (f"rtmgr {MANAGER} -s timer.tick=0.7", f"rtconf {MANAGER} set timer.tick 0.7"):
        assert manager.run(f"{line} --strict") == (1, "", f"{line.split()[0]}: {VAIN}\n")
    assert manager.ok(f"rtconf {MANAGER} get timer.tick") == "0.1\n"


def test_a_manager_whose_file_has_unknown_keys_does_not_start(shell: Any) -> None:
    place = shell.folder / "rtc.conf"
    place.write_text("manager.components.precreat: ConsoleIn\n")
    hint = "(did you mean manager.components.precreate?)"
    why = f"{place}:1: unknown property: manager.components.precreat {hint}"
    for word in ("start", "run"):
        assert shell.run(f"rtmgr {word} --strict") == (1, "", f"rtmgr: {why}\n")
    assert shell.run("rtmgr start") == (0, "", f"rtmgr: warning: {why}\n")


def test_what_a_start_makes_with_notes_fails_a_strict_one(shell: Any) -> None:
    item = "ConsoleIn?manager_nme=s"
    (shell.folder / "rtc.conf").write_text(f"manager.components.precreate: {item}\n")
    why = "unknown option: manager_nme (did you mean manager_name?)"
    status, _, err = shell.run("rtmgr start --strict")
    assert (status, err.splitlines()[0]) == (
        1,
        f"rtmgr: manager.components.precreate: {item} ({why})",
    )
    told = f"rtmgr: warning: manager.components.precreate: {item}: {why}\n"
    assert shell.run("rtmgr start") == (0, "", told)


@pytest.fixture
def profile(manager: Any) -> Path:
    """A system of one component, whose code has a callback that is none."""
    (manager.folder / "Odd.py").write_text(ODD)
    manager.run(f"rtmgr {MANAGER} -l ./Odd.py:OddInit -c Odd?manager_name=s")
    manager.ok("rtcryo --all -o sys.xml")
    manager.ok("rtteardown --exit sys.xml")
    manager.ok(f"rtmgr {MANAGER} -u ./Odd.py")
    return Path(manager.folder / "sys.xml")


@pytest.mark.parametrize("command", ["rtresurrect", "rtapply"])
def test_notes_on_what_is_made_are_told_or_taken_back(
    manager: Any, profile: Path, command: str
) -> None:
    before = manager.ok("rtls -R")
    status, _, err = manager.run(f"{command} --strict {profile}")
    assert (status, NO_CALLBACK in err) == (1, True)
    assert manager.ok("rtls -R") == before
    status, _, err = manager.run(f"{command} {profile}")
    assert (status, f"note: {NO_CALLBACK}" in err) == (0, True)
    assert "Odd0.rtc" in manager.ok("rtls /localhost")


@pytest.mark.parametrize("command", ["rtresurrect", "rtapply", "rtplan", "rtcheck"])
def test_misspelt_keys_of_a_profile_are_told_before_anything_is_done(
    manager: Any, profile: Path, command: str
) -> None:
    hint = "(did you mean rtkit.restart?)"
    why = f"Odd0: unknown property: rtkit.restrat {hint}"
    line = f"rtprofile set {profile} Odd0:rtkit.restrat=always"
    assert manager.run(f"{line} --strict") == (1, "", f"rtprofile set: {why}\n")
    assert "restrat" not in profile.read_text()
    status, _, err = manager.run(line)
    assert (status, f"warning: {why}" in err) == (0, True)
    before = manager.ok("rtls -R")
    assert manager.run(f"{command} --strict {profile}") == (1, "", f"{command}: {why}\n")
    assert manager.ok("rtls -R") == before
    assert f"{command}: warning: {why}\n" in manager.run(f"{command} {profile}").err


@pytest.mark.parametrize("command", ["rtresurrect", "rtapply"])
def test_a_misspelt_manager_is_not_started(manager: Any, command: str) -> None:
    manager.ok(f"rtmgr {MANAGER} -c ConsoleIn")
    manager.ok("rtcryo --all -o sys.xml")
    manager.ok("rtmgr start other")
    file = manager.folder / "sys.xml"
    text = file.read_text().replace("localhost/ConsoleIn0", "localhost/mangaer.mgr/ConsoleIn0")
    file.write_text(text)
    status, _, err = manager.run(f"{command} sys.xml")
    hint = "its name is so like manager, which runs (if it is meant: rtmgr start mangaer)"
    assert (status, hint in err) == (1, True)
    for line in ("rtls /localhost/mangaer", "rtls /localhost/mangaer.mgr"):
        assert "(did you mean /localhost/manager.mgr?)" in manager.run(line).err
    assert manager.run("rtmgr status mangaer").status == 1
