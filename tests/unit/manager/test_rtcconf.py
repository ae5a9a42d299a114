"""The text of rtc.conf, where it is looked for, and what is told of its faults."""

from __future__ import annotations

import pytest

from rtkit.errors import Malformed, Refused
from rtkit.settings.rtcconf import RtcConfEntry, candidates, parse, parse_override, warnings

TEXT = """\
# a comment
corba.nameservers: localhost
naming.formats:  %n.rtc , \\
    %h.host_cxt/%n.rtc

manager.components.precreate: A,\\
  # not this one
  B?x=http://1,\\
C
logger.enable:NO
    logger.log_level : DEBUG
manager.cpu_affinity:
"""


def test_the_syntax():
    assert parse(TEXT.encode(), "rtc.conf") == [
        RtcConfEntry("corba.nameservers", "localhost", 2),
        RtcConfEntry("naming.formats", "%n.rtc , %h.host_cxt/%n.rtc", 3),
        RtcConfEntry("manager.components.precreate", "A,B?x=http://1,C", 6),
        RtcConfEntry("logger.enable", "NO", 10),
        RtcConfEntry("logger.log_level", "DEBUG", 11),
        RtcConfEntry("manager.cpu_affinity", "", 12),
    ]


@pytest.mark.parametrize("end", ["\\", "\\\n", "\\\r\n", "\n", ""])
def test_the_last_line_may_end_in_any_way(end):
    assert parse(f"manager.name: a{end}".encode(), "f") == [RtcConfEntry("manager.name", "a", 1)]


@pytest.mark.parametrize(
    ("text", "error", "why"),
    [
        (b"# x\nnonsense\n", Malformed, "^rtc.conf:2: not KEY: VALUE: nonsense$"),
        (b"a b: 1", Malformed, "^rtc.conf:1: not a property key: 'a b'$"),
        (b": 1", Malformed, "^rtc.conf:1: not a property key: ''$"),
        (b"\n\nnaming.enable: \\\n  maybe", Malformed, "^rtc.conf:3: naming.enable: neither"),
        (b"\nnet.endpoints: 0.0.0.0:1", Refused, "^rtc.conf:2: net.endpoints: other hosts"),
        (b"a.b: 1\n\xff: 2", Malformed, "^rtc.conf:2: not UTF-8"),
        (b"#" * 2_000_000, Malformed, "larger"),
    ],
)
def test_bad_lines_are_told_with_their_place(text, error, why):
    with pytest.raises(error, match=why):
        parse(text, "rtc.conf")


def test_unknown_and_repeated_keys_are_told():
    text = b"corba.endpoints: none\nnaming.format: a\nnet.endpoints: all\nmine.own: 1"
    assert warnings(parse(text, "f"), "f") == [
        "f:2: unknown property: naming.format (did you mean naming.formats?)",
        "f:3: net.endpoints was given in line 1 already; this one counts",
        "f:4: unknown property: mine.own",
    ]


def test_overrides():
    assert parse_override("naming.formats: a/%n.rtc:x".removesuffix(":x")).value == "a/%n.rtc"
    assert parse_override("mine:a:b") == RtcConfEntry("mine", "a:b", 0)
    assert warnings([parse_override("mine:1")], "f") == ["unknown property: mine"]
    for text in ("", "a", ":a", "naming.enable:perhaps"):
        with pytest.raises(Malformed):
            parse_override(text)


def test_where_the_file_is_looked_for():
    found = list(candidates({}, "/home/me"))
    assert found[0] == ("/home/me/rtc.conf", False)
    assert ("/etc/rtc.conf", False) in found[1:]
    assert list(candidates({"RTC_MANAGER_CONFIG": "x.conf"}, "/d")) == [("/d/x.conf", True)]
    assert list(candidates({"RTC_MANAGER_CONFIG": "/x"}, "/d")) == [("/x", True)]


def test_what_is_given_in_vain_is_told():
    text = b"timer.tick: 0.5\nnaming.type: corba\nos.name: x\nlogger.clock_type:\nconfig.version: 1"
    assert warnings(parse(text, "f"), "f") == [
        "f:1: timer.tick has no effect: nothing is polled",
        "f:3: os.name is read-only: operating system of the manager",
    ]
