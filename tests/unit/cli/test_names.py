"""What rtdel and rtexit leave behind, and what shells make of rtcwd."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Callable
from typing import Any

import pytest
from fake_manager import FakeManager
from fake_tree import fake_tree

from rtkit.cli.tree.rtcwd import main as rtcwd
from rtkit.deployment import actions as act
from rtkit.deployment.actions import Result
from rtkit.rtc.enums import ReturnCode

Run = Callable[[str], Any]
SHELLS = [name for name in ("bash", "dash", "zsh", "fish", "tcsh") if shutil.which(name)]


def found(run: Run, name: str) -> list[str]:
    lines: list[str] = run(f"rtfind / -n {name}").out.splitlines()
    return lines


def test_a_component_without_a_name_is_found_below_its_manager(
    world: FakeManager, run: Run
) -> None:
    assert run("rtdel /localhost/Input0.rtc").status == 0
    assert found(run, "Input0.rtc") == [
        "/localhost/manager.mgr/Input0.rtc",
        "/localhost/manager.mgr/slave1.mgr/Input0.rtc",
    ]
    assert world.state_of("Input0") == "Inactive"


def test_one_name_of_several_goes(world: FakeManager, run: Run) -> None:
    world.update("Std0", names=("localhost/a/Std0.rtc", "box/b/Std0.rtc"))
    assert run("rtdel /localhost/b/Std0.rtc").status == 0
    assert world.components["Std0"].names == ("localhost/a/Std0.rtc",)


def test_a_directory_goes_with_every_name_in_it(world: FakeManager, run: Run) -> None:
    world.update("Std0", names=("localhost/dir/in/Std0.rtc", "localhost/dir2/Std0.rtc"))
    world.update("Text0", names=("localhost/dir/Text0.rtc",))
    world.names = (*world.names, "localhost/dir/manager.mgr")
    assert run("rtdel /localhost/dir").status == 0
    assert run("rtls /localhost/dir").err == "rtls: No such object: /localhost/dir\n"
    assert world.components["Std0"].names == ("localhost/dir2/Std0.rtc",)
    assert world.components["Text0"].names == ()
    assert world.names == ("localhost/manager.mgr",)


def test_a_manager_without_a_name_still_answers(world: FakeManager, run: Run) -> None:
    assert run("rtdel /localhost/manager.mgr").status == 0
    assert "manager.mgr" not in run("rtls /localhost").out
    assert run("rtls /localhost/Std0.rtc").status == 0


def test_zombies_go_with_their_last_name(world: FakeManager, run: Run) -> None:
    assert run("rtdel -z /localhost/Zombie0.rtc").status == 0
    assert "Zombie0" not in world.components
    assert "slave2" not in world.processes


def test_all_zombies_go_and_nothing_that_lives(world: FakeManager, run: Run) -> None:
    world.perform(act.Create("Std?instance_name=Nameless&manager_name=slave3"))
    world.update("Nameless", names=())
    world.update("Zombie0", names=("localhost/a/Z.rtc", "localhost/b/Z.rtc"))
    world.kill("slave3")
    before = set(world.components)
    assert run("rtdel -z") == (0, "", "")
    assert before - set(world.components) == {"Zombie0", "Nameless"}
    assert run("rtfind / -t z").out == ""
    assert run("rtdel -z") == (0, "", "")


def test_a_zombie_that_came_back_is_not_deleted(world: FakeManager, run: Run) -> None:
    def come_back(_action: act.Action) -> None:
        world.fault = lambda _: None
        assert world.perform(act.Create("Std?instance_name=Zombie0")).ok

    world.fault = come_back
    told = "rtdel: no zombie is registered as /localhost/Zombie0.rtc\n"
    assert run("rtdel -z") == (1, "", told)
    assert world.components["Zombie0"].names == ("localhost/Zombie0.rtc",)


def test_a_name_gone_meanwhile_is_no_failure(world: FakeManager, run: Run) -> None:
    world.fault = lambda _: Result(ReturnCode.BAD_PARAMETER, "not-found", "nothing is there")
    assert run("rtdel /localhost/Std0.rtc") == (0, "", "")


def test_nothing_remains_of_what_was_ended(world: FakeManager, run: Run) -> None:
    assert run("rtcon /localhost/Std0.rtc:out /localhost/Input0.rtc:in").status == 0
    assert run("rtexit /localhost/Std0.rtc").status == 0
    assert found(run, "Std0.rtc") == []
    assert world.connectors == {}


def test_why_a_component_does_not_end_is_told(world: FakeManager, run: Run) -> None:
    world.fault = lambda _: Result(ReturnCode.ERROR, "unreachable", "no answer from slave1 in time")
    outcome = run("rtexit /localhost/Input0.rtc")
    assert outcome == (1, "", "rtexit: no answer from slave1 in time\n")


@pytest.mark.parametrize(
    "name", ["plain", "a b", "$HOME", "`id`", "it's", '"x"', "a\\'b\\\\", "!!", "größe", "*", "~"]
)
@pytest.mark.parametrize("shell", SHELLS)
def test_no_shell_takes_a_name_for_its_own(
    world: FakeManager,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    shell: str,
    name: str,
) -> None:
    monkeypatch.setenv("SHELL", f"/bin/{shell}")
    world.update("Std0", names=(f"localhost/{name}/Std0.rtc",))
    assert rtcwd([f"/localhost/{name}"], tree=fake_tree(world)) == 0
    line = capsys.readouterr().out
    show = "import json, os; print(json.dumps(os.environ['RTCSH_CWD']))"
    script = f'{line}python3 -c "{show}"'
    done = subprocess.run([shell, "-c", script], capture_output=True, text=True, check=True)
    assert json.loads(done.stdout) == f"/localhost/{name}"
