"""Configuration sets."""

from __future__ import annotations

import pytest

from rtkit.component.configuration.config import Configuration, is_hidden
from rtkit.errors import Malformed, NotFound, Refused


@pytest.fixture
def reports():
    return []


@pytest.fixture
def config(reports):
    config = Configuration(reports.append)
    config.bind("gain", 1.0)
    config.bind("name", "x")
    config.declare("fast", {"gain": "5"})
    config.declare("__widget__", {"gain": "text"})
    return config


def test_default_exists_and_is_active(config):
    assert config.active_set == "default"
    assert config.sets["default"] == {"gain": "1.0", "name": "x"}
    assert config.values == {"gain": 1.0, "name": "x"}


def test_set_changes_text_only_and_of_one_set(config):
    config.set("default", {"gain": "2"})
    assert config.sets["default"]["gain"] == "2"
    assert config.sets["fast"] == {"gain": "5"}
    assert config.values["gain"] == 1.0
    assert not config.is_pending


def test_set_is_all_or_nothing(config):
    with pytest.raises(NotFound, match="No such configuration parameter: weight"):
        config.set("default", {"gain": "2", "weight": "3"})
    assert config.sets["default"]["gain"] == "1.0"
    with pytest.raises(NotFound, match="No such configuration set: slow"):
        config.set("slow", {"gain": "2"})


def test_activation_waits_for_update(config):
    config.activate("fast")
    assert config.is_pending
    assert config.active_set == "default"
    assert config.values["gain"] == 1.0
    assert config.update()
    assert config.active_set == "fast"
    assert config.values == {"gain": 5.0, "name": "x"}
    assert not config.update()


def test_text_written_after_an_activation_waits_for_the_next(config):
    config.activate("fast")
    config.set("fast", {"gain": "6"})
    config.update()
    assert config.values["gain"] == 5.0


def test_the_last_of_several_activations_counts(config):
    config.activate("fast")
    config.activate("default")
    config.update()
    assert config.active_set == "default"
    assert not config.is_pending


def test_text_that_cannot_be_read_gives_the_default_and_a_report(config, reports):
    config.set("fast", {"gain": "quick"})
    config.activate("fast")
    config.update()
    assert config.values["gain"] == 1.0
    assert config.active_set == "fast"
    (report,) = reports
    assert "fast.gain" in report
    assert "'quick'" in report


@pytest.mark.parametrize("name", ["", "_x", "__widget__"])
def test_some_sets_cannot_be_activated(config, name):
    with pytest.raises(Refused, match="cannot be activated"):
        config.activate(name)
    assert not config.is_pending


def test_an_unknown_set_cannot_be_activated(config):
    with pytest.raises(NotFound, match="No such configuration set: slow"):
        config.activate("slow")


def test_only_sets_added_at_run_time_are_removed(config):
    config.add_set("mine", {"gain": "9"})
    with pytest.raises(Refused, match="exists already"):
        config.add_set("mine", {})
    for name in ("default", "fast"):
        with pytest.raises(Refused, match="not added at run time"):
            config.remove_set(name)
    with pytest.raises(NotFound, match="No such configuration set: other"):
        config.remove_set("other")
    config.activate("mine")
    with pytest.raises(Refused, match="active"):
        config.remove_set("mine")
    config.update()
    with pytest.raises(Refused, match="active"):
        config.remove_set("mine")
    config.activate("default")
    config.update()
    config.remove_set("mine")
    assert "mine" not in config.sets


def test_changes_are_told(config):
    told = []
    config.changed = lambda change, name: told.append((change, name))
    config.set("fast", {"gain": "6"})
    config.add_set("mine", {})
    config.remove_set("mine")
    config.activate("fast")
    config.update()
    assert told == [
        ("parameter_updated", "fast.gain"),
        ("set_updated", "fast"),
        ("set_added", "mine"),
        ("set_removed", "mine"),
        ("set_activated", "fast"),
    ]


def test_what_was_handed_out_does_not_change(config):
    sets = config.sets
    config.set("fast", {"gain": "7"})
    assert sets["fast"] == {"gain": "5"}


@pytest.mark.parametrize(
    ("name", "hidden"),
    [("__widget__", True), ("default", False), ("__x", False), ("x__", False), ("____", False)],
)
def test_hidden_sets(name, hidden):
    assert is_hidden(name) is hidden


def test_a_parameter_that_the_set_does_not_name_keeps_its_value(config):
    config.set("default", {"name": "y"})
    config.activate("default")
    config.update()
    config.activate("fast")
    config.update()
    assert config.values == {"gain": 5.0, "name": "y"}


@pytest.fixture
def bound(config):
    """Return a configuration whose gain is declared to be at most 10."""
    config.declare("__type__", {"gain": "double"})
    config.declare("__constraints__", {"gain": "0<=x<=10", "name": "(a,b)"})
    config.declare("wild", {"gain": "99", "name": "c", "free": "anything"})
    return config


def test_texts_that_parameters_cannot_have_are_refused_all_together(bound):
    why = r"gain cannot be '11': it is to be 0<=x<=10; name cannot be 'c': it is to be \(a,b\)"
    with pytest.raises(Malformed, match=why):
        bound.set("default", {"gain": "11", "name": "c"})
    with pytest.raises(Malformed, match="gain cannot be 'y': it is no number"):
        bound.set("default", {"name": "a", "gain": "y"})
    assert bound.sets["default"] == {"gain": "1.0", "name": "x"}
    with pytest.raises(Malformed, match="gain cannot be '-1'"):
        bound.add_set("more", {"gain": "-1"})
    assert "more" not in bound.sets
    bound.set("fast", {"gain": "10"})
    bound.set("wild", {"free": "what"})


def test_a_set_with_such_texts_cannot_be_activated(bound):
    why = "set wild cannot be activated: gain cannot be '99': .*; name cannot be 'c'"
    with pytest.raises(Refused, match=why):
        bound.activate("wild")
    assert not bound.is_pending
    bound.set("wild", {"gain": "9", "name": "a"})
    bound.activate("wild")
    assert bound.update()
    assert bound.values == {"gain": 9.0, "name": "a"}


def test_a_default_that_its_author_forbids_is_let_be(bound):
    bound.activate("default")
    bound.set("default", {"name": "x", "gain": "2"})
    with pytest.raises(Malformed):
        bound.set("default", {"name": "y"})


def test_hints_are_no_values_and_hold_as_they_are_now(bound):
    bound.set("__constraints__", {"gain": "x<=3"})
    with pytest.raises(Malformed, match="it is to be x<=3"):
        bound.set("default", {"gain": "4"})


def test_parameters_are_listed_in_the_order_of_their_declaration():
    configuration = Configuration(lambda text: None)
    configuration.declare("default", {"second": "7"})
    for name in ("first", "second", "third"):
        configuration.bind(name, 0)
    assert list(configuration.sets["default"].items()) == [
        ("first", "0"),
        ("second", "7"),
        ("third", "0"),
    ]
