"""``rtls --watch``: again and again until interrupted."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from fake_manager import FakeManager
from fake_tree import fake_tree

from rtkit.cli.properties.rtget import main as rtget
from rtkit.cli.shared import terminal
from rtkit.cli.shared.command import Main
from rtkit.cli.tree.rtls import main as rtls
from rtkit.deployment import actions as act

Watch = Callable[..., tuple[int, list[float]]]


@pytest.fixture
def watch(world: FakeManager, monkeypatch: pytest.MonkeyPatch) -> Watch:
    """Return what watches a world to which, whenever it waits, the next thing happens."""

    def watched(
        arguments: list[str], *user_events: Callable[[], object]
    ) -> tuple[int, list[float]]:
        now = 1000.0
        waits: list[float] = []
        coming = iter(user_events)

        def wait_for(_sources: object, until: float | None, *, needs_reader: bool) -> set[int]:
            assert needs_reader
            nonlocal now
            if until is not None:
                waits.append(max(0.0, until - now))
                now = max(now, until)
                return set()
            user_event = next(coming, None)
            if user_event is None:
                raise KeyboardInterrupt
            user_event()
            return set()

        monkeypatch.setattr("rtkit.cli.shared.stdout_reader.wait_for", wait_for)
        monkeypatch.setattr("rtkit.api.observers.monotonic", lambda: now)
        monkeypatch.setattr("time.monotonic", lambda: now)
        monkeypatch.setattr("signal.signal", lambda *_: None)
        return rtls(arguments, tree=fake_tree(world)), waits

    return watched


def test_a_pipe_gets_what_has_changed(
    world: FakeManager, watch: Watch, capsys: pytest.CaptureFixture[str]
) -> None:
    place = "/localhost/local.host_cxt"
    status, waits = watch(
        ["--watch", place],
        lambda: world.perform(act.Create("Std", ("localhost/elsewhere.host_cxt/Two.rtc",))),
        lambda: world.perform(act.Create("Std", ("localhost/local.host_cxt/Two.rtc",))),
    )
    # At once, then after each change, but not before a second is over.
    assert (status, waits) == (130, [0.0, 1.0, 1.0])
    out = "Output0.rtc\n\nOutput0.rtc\nTwo.rtc\n"
    assert capsys.readouterr() == (out, "rtls: interrupted\n")


def test_a_terminal_is_cleared_each_time(
    world: FakeManager,
    watch: Watch,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(terminal, "is_terminal", lambda: True)
    monkeypatch.setenv("NO_COLOR", "1")
    status, waits = watch(
        ["-l", "--watch=0.25", "/localhost/Std0.rtc"], lambda: world.update("Std0", trouble="x")
    )
    assert (status, waits) == (130, [0.0, 0.25])
    line = "Inactive  2/0  1/0  1/0  0/0  Std0.rtc"
    assert capsys.readouterr().out == f"\x1b[H\x1b[2J{line}\n\x1b[H\x1b[2J{line}  (x)\n"


def test_json_stays_one_object_a_line(
    world: FakeManager, watch: Watch, capsys: pytest.CaptureFixture[str]
) -> None:
    watch(["--json", "--watch", "/localhost/Std0.rtc"], lambda: world.update("Std0", trouble="x"))
    assert [line[0] for line in capsys.readouterr().out.splitlines()] == ["{", "{"]


def test_the_end_of_what_is_watched_is_told(
    world: FakeManager, watch: Watch, capsys: pytest.CaptureFixture[str]
) -> None:
    status, _ = watch(["--watch", "/localhost/Std0.rtc"], lambda: world.perform(act.Delete("Std0")))
    assert status == 1
    told = "rtls: No such object: /localhost/Std0.rtc\n"
    assert capsys.readouterr() == ("Std0.rtc\n", told)


def test_what_follows_two_dashes_is_a_path(
    watch: Watch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert watch(["--", "--watch"])[0] == 1
    assert capsys.readouterr().err == "rtls: No such object: --watch\n"


@pytest.mark.parametrize("command", [rtls, rtget])
def test_help_shows_how_seconds_are_given(
    command: Main, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command(["-h"]) == 0
    assert "--watch[=SECONDS]" in capsys.readouterr().out
