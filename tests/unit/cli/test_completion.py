"""What is told to a shell at TAB: from the line to the candidates."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from itertools import product
from pathlib import Path
from typing import Any

import click
import pytest
from fake_manager import FakeManager
from fake_tree import fake_tree

from rtkit.cli.completion import grammar
from rtkit.cli.completion.answer import candidates, complete, shown
from rtkit.cli.completion.argument_types import KINDS
from rtkit.cli.completion.candidates import Files, named
from rtkit.cli.completion.fitting import is_fit
from rtkit.cli.completion.grammar import ask
from rtkit.cli.completion.line import quoted, read
from rtkit.cli.shared.commands import TABLE, load
from rtkit.component.ports.port_matching import refusal
from rtkit.rtc.serde import encode

BREAKS = " \t\n\"'><=;|&(:"


@pytest.mark.parametrize(
    ("text", "words", "typed", "kept", "quote"),
    [
        ("rtls ", ["rtls"], "", "", ""),
        ("rtls /a/b", ["rtls"], "/a/b", "", ""),
        ("rtcat /a.rtc:o", ["rtcat"], "/a.rtc:o", "/a.rtc:", ""),
        ("rtls --watch=1", ["rtls"], "--watch=1", "--watch=", ""),
        (r"rtls My\ Rob", ["rtls"], "My Rob", "", ""),
        ('rtls "My Rob', ["rtls"], "My Rob", "", '"'),
        (r'rtls "a\$b\c:d', ["rtls"], r"a$b\c:d", "", '"'),
        ("rtls '/a/b:", ["rtls"], "/a/b:", "", "'"),
        ("rtls /a/'b c", ["rtls"], "/a/b c", "/a/", "'"),
        ("A=1 B= rtls 'x y' \"\" z", ["rtls", "x y", ""], "z", "", ""),
        ("rtls a\\", ["rtls"], "a", "", ""),
    ],
)
def test_a_line_of_bash(text: str, words: list[str], typed: str, kept: str, quote: str) -> None:
    assert read(text, BREAKS) == (tuple(words), typed, kept, quote)


@pytest.mark.parametrize("text", ["plain", "a b", "it's", 'x"y', "$HOME", "`x`", "a\\b", "Größe*"])
@pytest.mark.parametrize("quote", ["", "'", '"'])
def test_what_is_put_in_is_what_was_meant(text: str, quote: str) -> None:
    typed = f"{quote}{quoted(text, quote)}{quote}"
    told = subprocess.run(
        ["bash", "-c", f"printf %s {typed}"], capture_output=True, text=True, check=True
    )
    assert told.stdout == text


def all_commands() -> list[tuple[str, click.Command]]:
    return [(name, load(name).command) for name in TABLE]


def test_every_option_is_completed_without_a_manager(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", "/nowhere")
    for name, command in all_commands():
        known = {option for p in command.params for option in p.opts if option.startswith("-")}
        told = candidates(name.split(), "-")
        assert isinstance(told, list)
        assert known <= {each.text for each in told}, name


def test_every_kind_of_word_is_known() -> None:
    assert {*grammar._BY_METAVAR.values(), *grammar._ARGUMENT_METAVAR.values()} <= KINDS


def test_each_argument_of_each_command_is_of_some_kind() -> None:
    for name, command in all_commands():
        # What takes no argument has one without a name, to say so.
        if any(isinstance(p, click.Argument) and p.metavar for p in command.params):
            first, *words = name.split()
            asked = ask(first, words, "")
            assert asked is not None
            assert asked.kind, f"{name}: the type of its first argument is not known"


@pytest.mark.parametrize(
    ("line", "kind", "typed"),
    [
        ("rtls -l /a", "anything", "/a"),
        ("rtact -e 1 A.rtc B", "inactive", "B"),
        ("rtdis -i", "option", "-i"),
        ("rtdis -i abc", "connector", "abc"),
        ("rtdis --id=abc", "connector", "abc"),
        ("rtdis -iabc P", "connected", "P"),
        ("rtcat -ll P", "anything:", "P"),
        ("rtls -- -x", "anything", "-x"),
        ("rtconf A.rtc g", "words", "g"),
        ("rtconf -s one A.rtc get g", "conf", "g"),
        ("rtprofile show a", "profile", "a"),
        ("rtprofile -v show a", "profile", "a"),
        ("rtprofile sh", "words", "sh"),
        ("rtprofile convert --to x", "words", "x"),
        ("rtprofile nonsense x", "", "x"),
        ("rtcheck --components d", "folder", "d"),
        ("rtls --watch 1", "anything", "1"),
        ("rtplan r.xml --set C", "parameter", "C"),
        ("rtplan --values v", "file", "v"),
    ],
)
def test_what_is_meant(line: str, kind: str, typed: str) -> None:
    name, *words, last = line.split(" ")
    asked = ask(name, words, last)
    assert asked is not None
    assert (asked.kind, asked.typed) == (kind, typed)


@pytest.fixture
def told(world: FakeManager) -> Callable[[str], list[str]]:
    def tell(line: str) -> list[str]:
        *words, typed = line.split(" ")
        found = candidates(words, typed, fake_tree(world))
        assert isinstance(found, list)
        return [each.text for each in found]

    return tell


HOST = "/localhost/"


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("rttype f", ["find-ports"]),
        ("rttype show RTC::TimedLong", ["RTC::TimedLong", "RTC::TimedLongSeq"]),
        ("rttype find-ports TimedLong", ["TimedLong", "TimedLongSeq"]),
        ("rttype show TimedLong RTC::Pose2", ["RTC::Pose2D"]),
        ("rtls ", ["/localhost/"]),
        ("rtls lo", ["localhost/"]),
        ("rtls /localhost/lo", [f"{HOST}local.host_cxt/"]),
        ("rtls /localhost/../localhost/lo", ["/localhost/../localhost/local.host_cxt/"]),
        ("rtls /localhost/Zo", [f"{HOST}Zombie0.rtc"]),
        ("rtls /nowhere/", []),
        ("rtls /localhost/Std0.rtc/", []),
        ("rtcwd /localhost/", [f"{HOST}local.host_cxt/", f"{HOST}manager.mgr/"]),
        ("rtact /localhost/Err", []),
        ("rtreset /localhost/", [f"{HOST}Err0.rtc", f"{HOST}manager.mgr/"]),
        ("rtact /localhost/St", [f"{HOST}Std0.rtc"]),
        ("rtact /localhost/Std0.rtc /localhost/St", []),
        ("rtdeact /localhost/", []),
        ("rtdeact -e 1 /localhost/St", [f"{HOST}Std0.rtc"]),
        ("rtdel -z /localhost/", [f"{HOST}Zombie0.rtc", f"{HOST}manager.mgr/"]),
        ("rtcat /localhost/Std0.rtc", [f"{HOST}Std0.rtc"]),
        ("rtcat /localhost/Std0.rtc:", [f"{HOST}Std0.rtc:in", f"{HOST}Std0.rtc:out"]),
        ("rtcat /localhost/Std0.rtc:x", []),
        ("rtcat localhost:28", []),
        ("rtcon /localhost/Std0", [f"{HOST}Std0.rtc:in", f"{HOST}Std0.rtc:out"]),
        ("rtcon /localhost/Std0.rtc:in /localhost/Std0.rtc:", [f"{HOST}Std0.rtc:out"]),
        (
            "rtcon /localhost/Std0.rtc:out /localhost/",
            [f"{HOST}{n}" for n in ("Err0.rtc:", "Input0.rtc:", "Std0.rtc:", "manager.mgr/")],
        ),
        ("rtcon /localhost/Adder0.rtc:offer /localhost/U", [f"{HOST}User0.rtc:need"]),
        ("rtcon /localhost/Text0.rtc:in /localhost/", []),
        ("rtcon /localhost/None.rtc:in /localhost/Te", [f"{HOST}Text0.rtc:in"]),
        ("rtdis /localhost/", []),
        ("rtprint /localhost/Std0", [f"{HOST}Std0.rtc:out"]),
        ("rtinject /localhost/Std0", [f"{HOST}Std0.rtc:in"]),
        ("rtcall /localhost/Add", [f"{HOST}Adder0.rtc:offer.add"]),
        (
            "rtcall /localhost/",
            [f"{HOST}{n}" for n in ("Adder0.rtc:", "User0.rtc:", "manager.mgr/")],
        ),
        ("rtcall /localhost/User0.rtc:", [f"{HOST}User0.rtc:also.add"]),
        ("rtcall /localhost/Adder0.rtc:offer.a", [f"{HOST}Adder0.rtc:offer.add"]),
        ("rtcall /localhost/Adder0.rtc:x", []),
        ("rtcall /localhost/Std0", []),
        ("rtcall /localhost/Adder0.rtc:offer.add 1", []),
        ("rtlog -p -f x /localhost/Std0", [f"{HOST}Std0.rtc:in"]),
        ("rtconf /localhost/Std0.rtc g", ["get"]),
        ("rtconf /localhost/Std0.rtc get ", ["param"]),
        ("rtconf /localhost/Std0.rtc set p", ["param="]),
        ("rtconf -s set2 /localhost/Std0.rtc set param=", ["param=2"]),
        ("rtconf /localhost/Std0.rtc set param ", ["0"]),
        ("rtconf /localhost/Std0.rtc diff ", ["default", "set1", "set2"]),
        ("rtconf /localhost/Std0.rtc act -s s", ["set1", "set2"]),
        ("rtconf /localhost/manager.mgr get naming.f", ["naming.formats"]),
        ("rtmgr -d St", ["Std0"]),
        ("rtmgr -s manager.nam", ["manager.name=", "manager.naming_formats="]),
        ("rtmgr sta", ["start", "status"]),
        ("rtmgr r", ["restart", "run", "replay"]),
        ("rtmgr /localhost/", [f"{HOST}manager.mgr", f"{HOST}manager.mgr/"]),
        (
            "rtexit /localhost/manager.mgr/sl",
            [f"{HOST}manager.mgr/slave{n}.mgr{s}" for n, s in ((1, ""), (1, "/"), (2, ""))],
        ),
        ("rtwait Std0.rtc act", ["active"]),
        ("rtkit c ", []),
        ("rtbug l", ["list"]),
        ("rtbug run --world o", ["one-box"]),
        ("rtbug run --variant alg", ["alg1", "alg2"]),
        ("rtkit bug run --sensors l", ["laser", "laser+ir"]),
        ("rtbug run --direction ", ["left", "right"]),
        ("rtkit conf /localhost/Std0.rtc g", ["get"]),
        ("/somewhere/bin/rtls lo", ["localhost/"]),
        ("rtkit shell-init z", ["zsh"]),
        ("rtkit resur", ["resurrect"]),
        ("rtkit help pat", ["paths"]),
        ("rtkit help resu", ["resurrect"]),
        ("ls lo", []),
    ],
)
def test_live_names(told: Callable[[str], list[str]], line: str, expected: list[str]) -> None:
    assert told(line) == expected


def test_names_are_relative_to_the_working_directory(
    told: Callable[[str], list[str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RTCSH_CWD", "/localhost")
    assert told("rtls Std") == ["Std0.rtc"]
    assert told("rtls /lo") == ["/localhost/"]
    assert told("rtcon Std0.rtc:out ../localhost/Inp") == ["../localhost/Input0.rtc:in"]


def test_connections(run: Any, world: FakeManager, told: Callable[[str], list[str]]) -> None:
    assert run("rtcon -i one /localhost/Std0.rtc:out /localhost/Input0.rtc:in").status == 0
    assert told("rtdis -i ") == ["one"]
    assert told("rtdis /localhost/Std0.rtc:") == [f"{HOST}Std0.rtc:out"]
    assert told("rtdis /localhost/Inp") == [f"{HOST}Input0.rtc"]
    assert told("rtdis /localhost/Std0.rtc /localhost/Inp") == [f"{HOST}Input0.rtc:in"]


def test_modules_of_installed_packages(
    told: Callable[[str], list[str]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "arm-1.dist-info").mkdir()
    entries = "[rtkit.components]\nArm = my_robot.arm:ArmInit\n"
    (tmp_path / "arm-1.dist-info" / "entry_points.txt").write_text(entries)
    (tmp_path / "my_robot").mkdir()
    (tmp_path / "my_robot" / "arm.py").write_text("")
    monkeypatch.syspath_prepend(tmp_path)
    assert told("rtmgr -l my_r") == ["my_robot.arm:ArmInit"]
    assert told("rtprofile from my_r") == ["my_robot.arm:ArmInit"]


def test_modules(run: Any, told: Callable[[str], list[str]]) -> None:
    assert told("rtmgr /localhost/manager.mgr -u ") == []
    assert run("rtmgr /localhost/manager.mgr -l b.py:bInit").status == 0
    assert told("rtmgr /localhost/manager.mgr -u ") == ["b.py"]
    assert told("rtmgr /localhost/manager.mgr -c ") == ["Output"]


def test_what_fits_is_what_the_rules_let_pass(world: FakeManager) -> None:
    ports = [(c.instance, port) for c in world.components.values() for port in c.ports]
    for (_, one), (_, other) in product(ports, ports):
        is_right = refusal((one, other), {}) == ""
        assert is_fit(encode(one), encode(other)) == is_right, (one, other)


def test_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("a.xml", "a.txt", "b.yaml", ".hidden.xml", "a\nb.xml"):
        (tmp_path / name).touch()
    (tmp_path / "sub").mkdir()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HOME", str(tmp_path))
    profiles = candidates(["rtresurrect"], "")
    assert isinstance(profiles, Files)
    assert [each.text for each in named(profiles, "")] == ["a.xml", "b.yaml", "sub/"]
    assert [each.text for each in named(profiles, "~/b")] == ["~/b.yaml"]
    assert [each.text for each in named(profiles, ".h")] == [".hidden.xml"]
    assert [each.text for each in named(Files(is_folder=True), "./")] == ["./sub/"]
    assert named(profiles, "nowhere/") == []


@pytest.mark.parametrize(
    ("arguments", "answer"),
    [
        (["bash", "9", BREAKS, "rtcat /localhost/Std0.rtc:o"], "space\nout\n"),
        (["bash", "9", BREAKS, "rtls '/localhost/Std"], "space\n/localhost/Std0.rtc\n"),
        (["bash", "9", BREAKS, "rtls /localhost/lo"], "nospace\n/localhost/local.host_cxt/\n"),
        (["bash", "9", BREAKS, "rtls '/localhost/lo"],
         "space\n/localhost/local.host_cxt/Output0.rtc\n"),
        (["bash", "9", BREAKS, "rtcwd '/localhost/lo"], "nospace\n/localhost/local.host_cxt/\n"),
        (["bash", "63", BREAKS, "rtcwd /localhost/"], "nospace\nlocal.host_cxt/\nmanager.mgr/\n"),
        (["zsh", "rtls", "/localhost/Std"], "space\n/localhost/Std0.rtc\tInactive\n"),
        (["zsh", "rtls", "/localhost/Zom"], "space\n/localhost/Zombie0.rtc\tzombie\n"),
        (["fish", "rtls", '"/localhost/Std'], "space\n/localhost/Std0.rtc\tInactive\n"),
        (["zsh", "rtstart", "x"], "files .xml .yaml .yml .json\n"),
        (["zsh", "rtbuild", "-o", "x"], "files /\n"),
        (["zsh", "rtcryo", "-o", "x"], "files\n"),
    ],
)  # fmt: skip
def test_answers(
    world: FakeManager, capsys: pytest.CaptureFixture[str], arguments: list[str], answer: str
) -> None:
    assert complete("rtkit", arguments, fake_tree(world)) == 0
    assert capsys.readouterr() == (answer, "")


@pytest.mark.parametrize("arguments", [[], ["bash"], ["csh", "rtls", ""], ["zsh", "x"]])
def test_who_asks_otherwise_is_told_how(
    capsys: pytest.CaptureFixture[str], arguments: list[str]
) -> None:
    assert complete("rtkit", arguments) == 2
    assert capsys.readouterr().err.startswith("Usage: rtkit complete bash")


@pytest.mark.parametrize(
    ("text", "expected"),
    [("/a/b", "b"), ("/a/b/", "b/"), ("/a/b:c", "b:c"), ("x", "x"), ("/", "/")],
)
def test_lists_show_the_last_name(text: str, expected: str) -> None:
    assert shown(text) == expected


def test_without_a_manager_nothing_is_offered_and_the_reason_is_on_stderr(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("RTKIT_RUNTIME_DIR", str(tmp_path))
    assert complete("rtkit", ["zsh", "rtls", "/localhost/"]) == 1
    assert capsys.readouterr() == (
        "",
        "rtkit complete: manager 'manager' is not running (start it with: rtmgr start)\n",
    )


@pytest.mark.parametrize("line", ["rtls --", "rtls /localhost/", "rtcat /localhost/A.rtc:"])
def test_nothing_heavy_is_imported(line: str, tmp_path: Path) -> None:
    heavy = ("asyncio", "lxml", "rich", "rtkit.deployment.facts", "rtkit.rtc.serde", "subprocess",
             "importlib.metadata", "rtkit.component", "rtkit.manager", "tempfile")  # fmt: skip
    script = (
        "import sys\n"
        "from rtkit.cli.unified import run\n"
        "import rtkit.tree.client\n"
        "from rtkit.deployment.listing import Listing, ListingRow\n"
        "names = ('localhost/A.rtc',)\n"
        "row = ListingRow('A', 'Active', 1, 1, 1, 0, 0, 0, 'm', '', '', False, names)\n"
        "rows = (row,)\n"
        "class Tree:\n"
        "    manager = 'm'\n"
        "    timeout_s = 1.0\n"
        "    def close(self): pass\n"
        "    def listing(self): return Listing('box', 'm', 1, (), rows)\n"
        "    def plain(self, names): return {'components': [{'instance': 'A', 'ports':\n"
        "        [{'name': 'in', 'port_type': 'DataInPort'}]}]}\n"
        f"assert run(['complete', 'bash', '9', {BREAKS!r}, {line!r}], tree=Tree()) == 0\n"
        f"print([name for name in {heavy} if name in sys.modules], file=sys.stderr)\n"
    )
    alone = {**os.environ, "RTKIT_RUNTIME_DIR": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False, env=alone
    )
    assert done.stderr == "[]\n"
    assert len(done.stdout.splitlines()) > 1


def test_set_offers_variables_and_parameters_of_the_profile(
    told: Callable[[str], list[str]],
) -> None:
    file = Path(__file__).parent / "files" / "systems" / "pairs.yaml"
    line = f"rtplan {file} --set "
    assert told(line) == ["limit=", "right=", "left.Range0.limit=", "right.Range0.limit="]
    assert told(f"{line}left.") == ["left.Range0.limit="]
    assert told("rtplan no-such.xml --set ") == []
    assert told(f"rtplan {__file__} --set ") == []
