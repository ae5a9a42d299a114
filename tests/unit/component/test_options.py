"""Connector properties."""

from __future__ import annotations

import pytest

from rtkit.component.ports.options import (
    BufferOptions,
    ConnectorOptions,
    EmptyPolicy,
    FullPolicy,
    PushPolicy,
    parse_options,
    remarks,
)
from rtkit.errors import Malformed
from rtkit.rtc.connector_properties import differing

IN = "dataport.inport.buffer."


def test_defaults():
    options = parse_options({})
    assert options == ConnectorOptions()
    assert (options.interface, options.dataflow, options.subscription) == ("zenoh", "push", "new")
    assert options.inport == BufferOptions(8, FullPolicy.OVERWRITE, 1.0, EmptyPolicy.READBACK, 1.0)


def test_values_do_not_care_about_case():
    options = parse_options(
        {
            "dataport.interface_type": "CORBA_CDR",
            "dataport.dataflow_type": "Push",
            "dataport.subscription_type": "Flush",
            "dataport.publisher.push_policy": "ALL",
            IN + "write.full_policy": "Do_Nothing",
            IN + "read.empty_policy": "BLOCK",
        }
    )
    assert options.interface == "zenoh"
    assert options.dataflow == "push"
    assert options.subscription == "flush"
    assert options.push_policy is PushPolicy.ALL
    assert options.inport.full_policy is FullPolicy.DO_NOTHING
    assert options.inport.empty_policy is EmptyPolicy.BLOCK
    assert options.outport.full_policy is FullPolicy.OVERWRITE


@pytest.mark.parametrize(("text", "length"), [("1", 2), ("2", 2), ("+9", 9)])
def test_lengths(text, length):
    assert parse_options({IN + "length": text}).inport.length == length


@pytest.mark.parametrize(
    ("key", "value", "wanted"),
    [
        (IN + "length", "0", "1 to 1000000"),
        (IN + "length", "-1", "1 to 1000000"),
        ("dataport.serializer.cdr.endian", "middle", "one of little, big"),
        ("dataport.serializer.cdr.endian", "little,middle", "one of little, big"),
    ],
)
def test_values_that_make_no_sense_are_refused(key, value, wanted):
    with pytest.raises(Malformed, match=f"{key}={value}: not {wanted}"):
        parse_options({key: value})


def test_what_is_not_known_is_told_with_what_is_nearest():
    assert remarks(
        {
            "dataport.inport.bufer.length": "3",
            "buffer.length": "3",
            "dataport.zz": "1",
            "dataport.subscription_type": "periodc",
            "dataport.interface_type": "CORBA_CDR",
            "dataport.serializer.cdr.endian": "little,big",
            "dataport.corba_cdr.inport_ior": "IOR:1",
            "dataport.inport": "",
            "rtkit.any_data_type": "YES",
            "description": "mine",
        }
    ) == [
        "unknown connector property: dataport.inport.bufer.length"
        " (did you mean dataport.inport.buffer.length?)",
        "unknown connector property: buffer.length (did you mean dataport.buffer.length?)",
        "unknown connector property: dataport.zz",
        "unknown value of dataport.subscription_type: periodc (did you mean periodic?)",
    ]


def test_a_side_may_be_left_open():
    options = parse_options(
        {"dataport.buffer.length": "20", "dataport.outport.buffer.length": "30"}
    )
    assert (options.inport.length, options.outport.length) == (20, 30)


def test_a_group_to_skip_fits_into_the_buffer():
    options = parse_options(
        {"dataport.publisher.push_policy": "skip", "dataport.publisher.skip_count": "20"}
    )
    assert options.outport.length == 21


@pytest.mark.parametrize("key", ["dataport.publisher.push_rate", "dataport.push_rate"])
def test_push_rate(key):
    assert parse_options({key: "12.5"}).push_rate == 12.5


@pytest.mark.parametrize(
    ("told", "rate"),
    [
        ({"dataport.push_interval": "0.5"}, 2.0),
        ({"dataport.push_interval": " "}, 1000.0),
        ({"dataport.push_interval": "0.5", "dataport.push_rate": "30"}, 30.0),
        ({"dataport.push_rate": "30", "dataport.publisher.push_rate": "40"}, 40.0),
    ],
)
def test_a_push_interval_counts_where_no_rate_is_stated(told, rate):
    assert parse_options(told).push_rate == rate


def test_what_is_unknown_passes():
    options = parse_options(
        {
            "dataport.subscription_type": "on_full_moon",
            "dataport.dataflow_type": "sideways",
            "dataport.interface_type": "pigeon",
            "my.key": "value",
        }
    )
    assert options.subscription == "new"
    assert options.dataflow == "sideways"
    assert options.interface == "pigeon"


@pytest.mark.parametrize(
    ("key", "text"),
    [
        (IN + "length", "eight"),
        (IN + "length", "8.5"),
        (IN + "length", "9999999999"),
        (IN + "length", "٣"),
        (IN + "write.timeout", "-1"),
        (IN + "write.timeout", "nan"),
        (IN + "read.timeout", "inf"),
        (IN + "write.full_policy", "maybe"),
        (IN + "read.empty_policy", "overwrite"),
        ("dataport.publisher.push_policy", "some"),
        ("dataport.publisher.push_rate", "0"),
        ("dataport.push_rate", "fast"),
        ("dataport.push_interval", "fast"),
        ("dataport.push_interval", "0"),
        ("dataport.push_interval", "-1"),
        ("dataport.push_interval", "nan"),
        ("dataport.publisher.skip_count", "-1"),
        ("dataport.publisher.skip_count", "1.5"),
    ],
)
def test_what_is_wrong_is_named(key, text):
    with pytest.raises(Malformed, match=key.replace(".", r"\.") + "=" + text.replace(".", r"\.")):
        parse_options({key: text})


def test_what_differs_but_by_name():
    kept = {"dataport.interface_type": "corba_cdr", "a": "1"}
    assert differing({"dataport.interface_type": "ZENOH", "a": "1"}, kept) == []
    assert differing({"dataport.interface_type": "direct", "a": "corba_cdr"}, kept) == [
        "a",
        "dataport.interface_type",
    ]
    assert differing({"b": ""}, kept) == ["b"]
    usual = {"dataport.interface_type": "corba_cdr", "dataport.dataflow_type": "push"}
    assert differing(usual, {}) == []
    assert differing({"dataport.dataflow_type": "pull"}, {}) == ["dataport.dataflow_type"]
    assert differing({}, kept) == []


@pytest.mark.parametrize(
    ("key", "one", "other"),
    [
        ("dataport.push_interval", "0.5", "0.50"),
        ("dataport.publisher.push_rate", "10", "1e1"),
        ("dataport.push_rate", "10", "10.0"),
        ("dataport.outport.buffer.length", "8", "+8"),
        ("dataport.buffer.read.timeout", "1", "1.0"),
        ("dataport.dataflow_type", "Push", ""),
    ],
)
def test_numbers_compare_as_numbers_and_words_as_words(key, one, other):
    assert differing({key: one}, {key: other}) == differing({key: other}, {key: one}) == []


def test_other_numbers_and_what_is_none_differ():
    key = "dataport.push_interval"
    for one, other in (("0.5", "0.51"), ("fast", "slow"), ("nan", "NaN"), ("0", ""), ("1", "x")):
        assert differing({key: one}, {key: other}) == [key]
    assert differing({"my.version": "1.10"}, {"my.version": "1.1"}) == ["my.version"]


def test_a_service_connector_need_not_state_its_port_type():
    stated = {"port.port_type": "CorbaPort"}
    assert differing(stated, {}) == differing({}, stated) == differing(stated, stated) == []
    assert differing(stated, {"port.port_type": "DataInPort"}) == ["port.port_type"]


@pytest.mark.parametrize(("told", "meant"), [("block", "flush"), ("NonBlock", "new")])
def test_subscription_types_of_openrtm_2_are_known(told: str, meant: str) -> None:
    assert parse_options({"dataport.subscription_type": told}).subscription == meant
