"""Laws of configuration sets, and of the names and texts around them."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from rtkit.component.configuration.config import Configuration
from rtkit.component.configuration.kinds import kind_of
from rtkit.errors import Malformed, NotFound, Refused
from rtkit.rtc.data_types import is_same_type, scoped_name

SETS = st.sampled_from(["default", "fast", "slow", "__widget__", "_x", ""])
DECLARED = {"default", "fast", "__widget__"}


class ConfigurationMachine(RuleBasedStateMachine):
    def __init__(self):
        super().__init__()
        self.reports = []
        self.config = Configuration(self.reports.append)
        self.config.bind("gain", 0)
        self.config.declare("fast", {"gain": "5"})
        self.config.declare("__widget__", {"gain": "text"})
        self.wished = None

    @rule(name=SETS, text=st.sampled_from(["1", "2", "x"]))
    def set(self, name, text):
        before = {k: v for k, v in self.config.sets.items() if k != name}
        values = dict(self.config.values)
        try:
            self.config.set(name, {"gain": text})
        except NotFound:
            assert name not in self.config.sets or "gain" not in self.config.sets[name]
        else:
            assert self.config.sets[name]["gain"] == text
        assert {k: v for k, v in self.config.sets.items() if k != name} == before
        assert self.config.values == values

    @rule(name=SETS)
    def activate(self, name):
        try:
            self.config.activate(name)
        except (NotFound, Refused):
            assert name not in self.config.sets or name.startswith("_") or not name
        else:
            self.wished = (name, self.config.sets[name].get("gain"))

    @rule(name=SETS)
    def add(self, name):
        before = dict(self.config.sets)
        try:
            self.config.add_set(name, {"gain": "7"})
        except (Refused, Malformed):
            assert self.config.sets == before
        else:
            assert name not in before
            assert not name.startswith("_")

    @rule(name=SETS)
    def remove(self, name):
        try:
            self.config.remove_set(name)
        except (NotFound, Refused):
            return
        assert name not in DECLARED
        assert name != self.config.active_set
        assert self.wished is None or name != self.wished[0]

    @rule()
    def update(self):
        told = len(self.reports)
        before = dict(self.config.values)
        assert self.config.update() == (self.wished is not None)
        if self.wished is None:
            assert self.config.values == before
            return
        name, text = self.wished
        self.wished = None
        assert self.config.active_set == name
        assert self.config.values["gain"] == (0 if text == "x" else int(text))
        assert (len(self.reports) > told) == (text == "x")

    @invariant()
    def what_came_with_the_component_stays(self):
        assert set(self.config.sets) >= DECLARED
        assert self.config.active_set in self.config.sets


TestConfiguration = ConfigurationMachine.TestCase


@given(
    st.one_of(
        st.booleans(),
        st.integers(),
        st.floats(allow_nan=False),
        st.text(),
        st.lists(st.floats(allow_nan=False)).map(tuple),
        st.lists(st.integers(), min_size=1).map(tuple),
    )
)
def test_every_default_is_written_so_that_it_reads_back(default):
    kind = kind_of(default)
    assert kind.read(kind.write(default)) == default


IDENTIFIER = st.from_regex(r"[A-Za-z][A-Za-z0-9_]{0,8}", fullmatch=True).filter(
    lambda name: name.lower() not in ("any", "idl")
)


@given(scope=st.lists(IDENTIFIER, max_size=3), name=IDENTIFIER)
def test_all_forms_of_a_type_name_are_one(scope, name):
    plain = "::".join([*scope, name])
    forms = [plain, f"::{plain}", "IDL:" + "/".join([*scope, name]) + ":1.0"]
    assert {scoped_name(form) for form in forms} == {plain}
    assert scoped_name(plain) == plain
    assert all(is_same_type(one, other) for one in [*forms, name] for other in forms)
