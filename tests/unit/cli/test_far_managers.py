"""``rtmgr start --host`` and ``stop --host``: what is told of several hosts, and the status."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from rtkit.cli.hosts import far_managers
from rtkit.cli.managers.rtmgr import main
from rtkit.errors import NotFound, Unreachable
from rtkit.hosts import bring_up
from rtkit.hosts.bring_up import BroughtUp
from rtkit.hosts.host import Host
from rtkit.hosts.progress import HostStep, Progress
from rtkit.hosts.provisioned import Provisioned

OLD = Provisioned("1.0-new", False, 0)


@pytest.fixture(autouse=True)
def hosts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Have an inventory of three hosts."""
    text = "".join(f'[{name}]\naddress = "x"\n' for name in ("one", "two", "three"))
    (tmp_path / "hosts.toml").write_text(text)
    monkeypatch.chdir(tmp_path)
    near = SimpleNamespace(close=lambda: None)
    monkeypatch.setattr(far_managers, "_near", lambda _app: near)


def _started(monkeypatch: pytest.MonkeyPatch, work: Callable[[Host, Progress], BroughtUp]) -> None:
    def start(host: Host, _near: Any, show: Progress, **_more: Any) -> BroughtUp:
        return work(host, show)

    monkeypatch.setattr(bring_up, "start", start)


def test_each_host_has_a_line_in_the_order_of_the_command(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    done = {
        "one": BroughtUp(Provisioned("1.0-new", True, 35_700_000), False, ""),
        "two": BroughtUp(Provisioned("1.0-new", False, 0), True, ""),
        "three": BroughtUp(Provisioned("1.0-new", True, 2_400_000), True, "1.0-old"),
    }
    _started(monkeypatch, lambda host, _show: done[host.name])
    assert main(["start", "--host", "two", "--host", "three", "--host", "one"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "two: linked, manager ran already",
        "three: linked, manager ran already; it runs with rtkit 1.0-old until --replace has it"
        " end; rtkit 1.0-new is new there, 2.4 MB sent",
        "one: linked, manager started; rtkit 1.0-new is new there, 35.7 MB sent",
    ]


def test_what_ended_for_a_manager_is_told(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    _started(monkeypatch, lambda _host, _show: BroughtUp(OLD, False, "", "1.0-old", "m2"))
    assert main(["start", "--host", "one"]) == 0
    assert capsys.readouterr().out == (
        "one: linked, manager replaced; that of rtkit 1.0-old has ended, with its components;"
        " the link to m2 there has ended\n"
    )


def test_the_status_is_that_of_the_first_host_named_that_failed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    two_failed = threading.Event()

    def work(host: Host, _show: Progress) -> BroughtUp:
        if host.name == "two":
            raise NotFound("two: no wheels")
        if host.name == "three":
            return BroughtUp(OLD, True, "")
        assert two_failed.wait(10.0)
        raise Unreachable("one: away")

    _started(monkeypatch, work)
    monkeypatch.setenv("RTKIT_EXIT_DETAIL", "1")
    fail = far_managers.App.fail

    def failing(app: Any, text: str) -> None:
        fail(app, text)
        two_failed.set()

    monkeypatch.setattr(far_managers.App, "fail", failing)
    line = ["start", "--host", "one", "--host", "two", "--host", "three"]
    assert main(line) == Unreachable.detail
    told = capsys.readouterr()
    assert told.err.splitlines() == ["rtmgr: two: no wheels", "rtmgr: one: away"]
    assert told.out == "three: linked, manager ran already\n"


def test_a_host_without_its_option_is_no_name_of_a_manager(
    capsys: pytest.CaptureFixture[str],
) -> None:
    for word in ("start", "stop"):
        assert main([word, "--host", "one", "two"]) == 2
        hint = f"rtmgr {word} --host one --host two"
        assert f"two is a host: {hint} (--host before each)" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("line", "status", "why"),
    [
        ("start --host one -p 3000", 2, "no -f, -o, -p, -a, -i"),
        ("start --host one -o a:b", 2, "no -f, -o, -p, -a, -i"),
        ("start --host one -i", 2, "no -f, -o, -p, -a, -i"),
        ("start --host one --tls 2811", 2, "-i, --tls, --allow-faults"),
        ("start --host one localhost:2810", 1, "an address is no name of a manager"),
        ("start --host one a/b", 1, "instance name 'a/b' has"),
        ("start --host four", 1, "no such host: four"),
        ("restart --host one", 2, "--host is for rtmgr start and stop"),
        ("start --host one --keep", 2, "--keep is for rtmgr stop"),
    ],
)
def test_what_makes_no_sense_is_refused_before_a_host_is_asked(
    line: str, status: int, why: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(line.split()) == status
    assert why in capsys.readouterr().err


def test_a_manager_of_another_name_is_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    _started(monkeypatch, lambda _host, _show: BroughtUp(OLD, False, ""))
    assert main(["start", "arm", "--host", "one"]) == 0
    assert capsys.readouterr().out == "one: linked, arm started\n"


def test_steps_are_told_by_lines_where_there_is_no_terminal(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def work(host: Host, show: Progress) -> BroughtUp:
        show(host.name, HostStep("connecting"))
        show(host.name, HostStep("sending", 1_000_000, 2_000_000, "MB"))
        return BroughtUp(OLD, False, "")

    _started(monkeypatch, work)
    main(["start", "--host", "one"])
    assert capsys.readouterr().err == ""
    main(["start", "--host", "one", "-v"])
    assert capsys.readouterr().err == "one: connecting\none: sending 1.0 of 2.0 MB\n"


def test_who_interrupts_is_told_which_hosts_were_done(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def outcomes(hosts: list[Host], *_more: object) -> Any:
        yield hosts[0], "linked"
        raise KeyboardInterrupt

    monkeypatch.setattr("rtkit.hosts.at_once.at_once", outcomes)
    assert main(["start", "--host", "two", "--host", "one"]) == 130
    told = capsys.readouterr()
    assert told.out == "two: linked\n"
    assert told.err == "rtmgr: interrupted; the same command goes on where this one was\n"
