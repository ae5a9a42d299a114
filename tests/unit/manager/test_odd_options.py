"""Options of create strings that mean nothing, and what they are told to be near to."""

from __future__ import annotations

import pytest

from rtkit.component import Component, Parameter
from rtkit.component.composite import TYPES
from rtkit.component.standin import stand_in
from rtkit.container.component_factory import odd_options
from rtkit.rtc.pattern import ComponentPattern
from rtkit.rtc.profiles import TypeProfile


class Scale(Component):
    """Scales."""

    factor = Parameter(1.0)


@pytest.mark.parametrize(
    ("key", "told"),
    [
        (
            "conf.default.factr",
            "A has no parameter factr (did you mean factor?): conf.default.factr",
        ),
        ("conf.fast.zz", "A has no parameter zz: conf.fast.zz"),
        ("conf.factor", "not conf.SET.PARAMETER: conf.factor"),
        (
            "exec_cxt.periodc.rate",
            "unknown option: exec_cxt.periodc.rate (did you mean exec_cxt.periodic.rate?)",
        ),
        ("rtkit.restrat", "unknown option: rtkit.restrat (did you mean rtkit.restart?)"),
        ("manager_nme", "unknown option: manager_nme (did you mean manager_name?)"),
        (
            "dataport.bufer.length",
            "unknown connector property: dataport.bufer.length"
            " (did you mean dataport.buffer.length?)",
        ),
    ],
)
def test_what_is_not_known_is_told(key: str, told: str) -> None:
    assert odd_options(Scale("A"), {key: "1"}) == [told]


@pytest.mark.parametrize(
    "key",
    [
        "conf.default.factor",
        "conf.fast.factor",
        "conf.__widget__.factor",
        "instance_name",
        "exec_cxt.periodic.rate",
        "ec.fast.rate",
        "rtkit.restart.delay",
        "rtkit.health.rate.in",
        "port.outport.out.dataport.x",
        "dataport.outport.buffer.length",
        "logger.log_level",
        "a_word_of_its_own",
    ],
)
def test_what_is_known_or_may_be_the_component_s_own_is_not(key: str) -> None:
    assert odd_options(Scale("A"), {key: "1"}) == []


def test_what_has_no_parameters_that_are_known_is_not_judged() -> None:
    given = {"conf.default.anything": "1"}
    assert odd_options(stand_in(ComponentPattern(TypeProfile("T")), "A", given), given) == []
    for kind in TYPES.values():
        members = {"conf.default.members": "B"}
        assert odd_options(kind("A", members), members) == []
