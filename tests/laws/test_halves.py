"""Laws of connectors between two managers: whatever dies, in whatever order, no half lies for long.

Both managers, and slaves of theirs, die and come back at any moment, letters are lost or late. Once
all is calm, both know a connector that is really joined, or neither does, or a half says why.
"""

from __future__ import annotations

from fake_peers import FakeHost
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import (
    RuleBasedStateMachine,
    invariant,
    precondition,
    rule,
    run_state_machine_as_test,
)

from rtkit.deployment.actions import Delete, Disconnect
from rtkit.manager.core.recovery import lives

NAMES = ("m1", "m2")
names = st.sampled_from(NAMES)
ids = st.sampled_from(("v", "w"))
OTHER = {"m1": "m2", "m2": "m1"}


class TwoManagers(RuleBasedStateMachine):
    def __init__(self):
        super().__init__()
        self.host = FakeHost(*NAMES)
        for name in NAMES:
            for instance in "AB":
                self.host.make(name, instance, instance.lower())

    def ask(self, name, *actions):
        if name in self.host.shells:
            self.host.ask(name, *actions)

    @rule(name=names, id=ids, flow=st.sampled_from(("push", "pull")))
    def connect(self, name, id, flow):
        self.ask(name, self.host.connector(id, name, flow))

    @rule(name=names, id=ids)
    def disconnect(self, name, id):
        self.ask(name, Disconnect(id))

    @rule(name=names, instance=st.sampled_from("AB"))
    def delete(self, name, instance):
        self.ask(name, Delete(instance))

    @rule(name=names, instance=st.sampled_from("AB"))
    def make(self, name, instance):
        if name in self.host.shells:
            self.host.make(name, instance, instance.lower())

    @rule(name=names)
    def kill(self, name):
        if name in self.host.shells:
            self.host.kill(name)

    @rule(name=names)
    def start(self, name):
        if name not in self.host.shells:
            self.host.start(name)

    @rule(name=names, really=st.integers(0, 3))
    def forget(self, name, really):
        if name in self.host.shells and not really:
            self.host.forget(name)

    @rule(name=names, index=st.integers(0, 3))
    def end_slave(self, name, index):
        pids = sorted(self.host.slaves[name])
        if index < len(pids):
            self.host.end_slave(name, pids[index])

    @precondition(lambda self: self.host.letters)
    @rule(count=st.integers(1, 4), is_lost=st.booleans())
    def deliver(self, count, is_lost):
        for _ in range(min(count, len(self.host.letters))):
            if self.host.letters:
                self.host.deliver(is_lost=is_lost)

    @rule(seconds=st.sampled_from((0.5, 3.0, 20.0)))
    def wait(self, seconds):
        self.host.wait(seconds)

    @rule()
    def calm(self):
        self.host.calm(15.0)
        self.check_calm()

    @invariant()
    def a_half_is_shown_with_its_own_end_only(self):
        for name, shell in self.host.shells.items():
            for connector in shell.state.connectors.values():
                assert any(end.instance.startswith(OTHER[name]) for end in connector.ports)

    def check_calm(self):
        for id in ("v", "w"):
            shown = [self.host.trouble(name, id) for name in self.host.shells]
            if "" in shown:  # who shows it whole is right
                assert shown == ["", ""], (id, shown)
                assert self.host.is_joined(id), id
            assert not any("not been met" in (each or "") for each in shown), shown
        for _, shell in self.host.shells.items():
            assert not shell.state.openings
            watched = set(shell.watched)
            assert watched == set(shell.state.kept.far), "who is met for nothing"

    def teardown(self):
        for name in NAMES:
            self.start_again(name)
        self.host.calm(40.0)
        self.check_calm()
        for id in ("v", "w"):
            shown = [self.host.trouble(name, id) for name in NAMES]
            rows = [("wire", id) in self.host.rows[name] for name in NAMES]
            if rows == [True, True] and self.all_live(id):
                assert shown == ["", ""], "both want it, and can"

    def all_live(self, id):
        return all(
            lives(shell.state, shell.state.kept.wires[id].ports[n].instance)
            for shell in self.host.shells.values()
            for n in (0, 1)
            if not shell.state.kept.wires[id].ports[n].instance.startswith("m")
        )

    def start_again(self, name):
        if name not in self.host.shells:
            self.host.start(name)


def test_two_managers():
    run_state_machine_as_test(
        TwoManagers, settings=settings(max_examples=30, stateful_step_count=20, deadline=None)
    )
