"""Names are aliases: they come and go, what bears them stays."""

from __future__ import annotations

import pytest
from fake_shell import OWN, FakeShell

from rtkit.deployment.actions import Create, Register, Unregister


def names(shell: FakeShell, instance: str) -> tuple[str, ...]:
    return shell.state.components[instance].names


def test_a_component_outlives_its_name(shell: FakeShell) -> None:
    shell.make("A")
    assert shell.ask(Unregister("localhost/A.rtc")).result.ok
    assert names(shell, "A") == ()
    assert not shell.calls


def test_only_the_name_that_was_meant_goes(shell: FakeShell) -> None:
    asked = shell.ask(Create("Thing?instance_name=A", ("localhost/x/A.rtc", "localhost/y/A.rtc")))
    shell.serve()
    assert asked.result.ok
    assert shell.ask(Unregister("localhost/x/A.rtc")).result.ok
    assert names(shell, "A") == ("localhost/y/A.rtc",)


def test_a_name_that_was_removed_can_be_given_again(shell: FakeShell) -> None:
    shell.make("A")
    shell.ask(Unregister("localhost/A.rtc"))
    asked = shell.ask(Create("Thing?instance_name=B", ("localhost/A.rtc",)))
    shell.serve()
    assert asked.result.ok
    assert names(shell, "B") == ("localhost/A.rtc",)


def test_a_zombie_goes_with_its_last_name_and_its_process_with_it(shell: FakeShell) -> None:
    named = ("localhost/x/A.rtc", "localhost/y/A.rtc")
    asked = shell.ask(Create("Thing?instance_name=A&manager_name=s1", named))
    key = shell.fork("s1")
    shell.serve()
    assert asked.result.ok
    shell.end(key)
    assert shell.ask(Unregister(named[0], is_zombie=True)).result.ok
    assert names(shell, "A") == (named[1],)
    assert shell.ask(Unregister(named[1], is_zombie=True)).result.ok
    assert "A" not in shell.state.components
    assert key not in shell.state.processes


def test_what_lives_is_no_zombie(shell: FakeShell) -> None:
    shell.make("A")
    result = shell.ask(Unregister("localhost/A.rtc", is_zombie=True)).result
    assert (result.kind, result.why) == ("refused", "no zombie is registered as /localhost/A.rtc")
    result = shell.ask(Unregister("localhost/manager.mgr", is_zombie=True)).result
    assert result.kind == "refused"
    assert names(shell, "A") == ("localhost/A.rtc",)
    assert shell.state.names == ("localhost/manager.mgr",)


def test_a_manager_outlives_its_name(shell: FakeShell) -> None:
    assert shell.ask(Unregister("localhost/manager.mgr")).result.ok
    assert shell.state.snapshot().names == ()
    assert shell.make("A") == OWN


def test_a_manager_s_name_is_taken(shell: FakeShell) -> None:
    result = shell.ask(Create("Thing?instance_name=A", ("localhost/manager.mgr",))).result
    assert result.why == "name /localhost/manager.mgr is taken by manager manager"


def test_a_name_that_nobody_bears(shell: FakeShell) -> None:
    result = shell.ask(Unregister("localhost/A.rtc")).result
    assert (result.kind, result.why) == (
        "not-found",
        "nothing is registered as /localhost/A.rtc",
    )


# names that cannot be found


@pytest.mark.parametrize(
    ("first", "second", "why"),
    [
        (
            "localhost/a",
            "localhost/a/b.rtc",
            "is below /localhost/a, which is no",
        ),
        (
            "localhost/a/b.rtc",
            "localhost/a",
            "is a directory: it has /localhost/a/b.rtc",
        ),
        ("localhost/a.rtc", "localhost/a.rtc/x/y.rtc", "is below /localhost/a.rtc, which is no"),
        (
            "localhost/b.rtc",
            "localhost/manager.mgr/b.rtc",
            "is below /localhost/manager.mgr,",
        ),
        ("localhost/b.rtc", "localhost/manager.mgr", "is taken by manager manager"),
    ],
)
def test_names_that_would_hide_each_other(
    shell: FakeShell, first: str, second: str, why: str
) -> None:
    shell.ask(Create("Thing?instance_name=A", (first,)))
    shell.serve()
    refused = shell.ask(Create("Thing?instance_name=B", (second,))).result
    assert refused.kind == "refused"
    assert why in refused.why
    assert not shell.state.claims


def test_the_place_below_a_manager_is_no_name(shell: FakeShell) -> None:
    for name, place in (("A", ""), ("B", "s1.mgr/")):
        path = f"localhost/manager.mgr/{place}{name}.rtc"
        asked = shell.ask(Create(f"Thing?instance_name={name}", (path,)))
        shell.serve()
        assert asked.result.ok
        assert names(shell, name) == ()


def test_names_below_directories_do_not_hide_each_other(shell: FakeShell) -> None:
    for name in ("a/x.rtc", "a/xy.rtc", "ab.rtc", "a.rtc"):
        asked = shell.ask(Create("Thing", (f"localhost/{name}",)))
        shell.serve()
        assert asked.result.ok


def test_a_component_that_lives_is_given_a_name_again(shell: FakeShell) -> None:
    key = shell.make("A", "s")
    shell.make("B")
    shell.ask(Unregister("localhost/A.rtc"))
    told = len(shell.told)
    assert shell.ask(Register("A", "localhost/x/A.rtc")).result.ok
    assert names(shell, "A") == ("localhost/x/A.rtc",)
    assert shell.state.kept.components["A"].names == ("localhost/x/A.rtc",)
    assert [each[0] for each in shell.told[told:]] == [key]
    assert shell.ask(Register("A", "localhost/x/A.rtc")).result.ok
    assert shell.ask(Register("A", "localhost/B.rtc")).result.kind == "refused"
    assert shell.ask(Register("C", "localhost/C.rtc")).result.kind == "not-found"
    assert names(shell, "A") == ("localhost/x/A.rtc",)
