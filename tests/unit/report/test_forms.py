"""Findings in each form, checked as those who read the form would."""

from __future__ import annotations

import json
import re
from typing import Any

import pytest
from lxml import etree

from rtkit.report.finding import ERROR, NOTE, WARNING, Checked, Finding
from rtkit.report.forms import FORMS, report_lines
from rtkit.report.junit import junit
from rtkit.report.lines import github_lines, json_lines, plain_lines
from rtkit.report.sarif import sarif, uri

NASTY = "100%\r\n<b>&\"'::warning::,\x1b[31m\u2028日本\udcff"
RULES = {"bad-value": "A value is wrong", "name": "A name is used twice"}
ERR = Finding(
    ERROR, "bad-value", "x is 'y'", "a b/ü.xml", 3, "/a/b[2]/@x", found="y", allowed="z, w"
)
NOTED = Finding(NOTE, "name", "name q is used twice", "a b/ü.xml", 9, "/a/b")
WARNED = Finding(WARNING, "other", "odd", "c.xml")
BAD = Checked("a b/ü.xml", "RTS profile", (ERR, NOTED))
GOOD = Checked("c.xml", "RTC profile", (WARNED,))
GONE = Checked("d.xml", "", (Finding(ERROR, "unreadable", "cannot be read", "d.xml"),), False)
HOSTILE = Checked(NASTY, "", (Finding(ERROR, NASTY, NASTY, NASTY, 1, NASTY, NASTY, NASTY),))
ALL = [BAD, GOOD, GONE, HOSTILE]


def test_plain_lines_tell_all_and_the_verdict() -> None:
    assert list(plain_lines([BAD, GOOD, GONE])) == [
        "a b/ü.xml:3: error: x is 'y'; allowed: z, w [bad-value] /a/b[2]/@x",
        "a b/ü.xml:9: note: name q is used twice [name] /a/b",
        "a b/ü.xml: invalid (RTS profile, 1 error, 1 note)",
        "c.xml: warning: odd [other]",
        "c.xml: valid (RTC profile, 1 warning)",
        "d.xml: error: cannot be read [unreadable]",
        "d.xml: not checked",
        "3 checked: 1 valid, 1 invalid, 1 not checked (2 errors, 1 warning, 1 note)",
    ]


def test_each_part_of_a_line_has_its_style() -> None:
    lines = list(plain_lines([BAD], lambda text, role: f"<{role}>{text}</>"))
    assert lines[0] == (
        "<name>a b/ü.xml:3</>: <error>error</>: <text>x is 'y'; allowed: z, w</> "
        "<path>[bad-value]</> <path>/a/b[2]/@x</>"
    )
    assert lines[2].startswith("<name>a b/ü.xml</>: <error>invalid</> (")


def test_what_is_allowed_is_told_once() -> None:
    told = Finding(ERROR, "r", "x is 1; allowed: 2", "f", allowed="2")
    assert told.full_text == "x is 1; allowed: 2"
    assert told._replace(text="x has no y", allowed="any text").full_text == "x has no y"


@pytest.mark.parametrize("form", FORMS)
def test_quiet_leaves_errors_only(form: str) -> None:
    said = "\n".join(report_lines(form, [BAD, GOOD], RULES, "t", "2025-01-01T00:00:00"))
    quiet = "\n".join(
        report_lines(form, [BAD, GOOD], RULES, "t", "2025-01-01T00:00:00", is_quiet=True)
    )
    assert ("used twice" in said, "odd" in said) == (True, True)
    assert ("used twice" in quiet, "odd" in quiet) == (False, False)
    assert "x is 'y'" in quiet


def test_json_is_one_object_a_line() -> None:
    first, second = map(json.loads, json_lines([BAD, GOOD]))
    assert first == {
        "schema": "rtkit.checked/1",
        "file": "a b/ü.xml",
        "what": "RTS profile",
        "valid": False,
        "findings": [
            {
                "severity": "error",
                "rule": "bad-value",
                "text": "x is 'y'",
                "file": "a b/ü.xml",
                "line": 3,
                "xpath": "/a/b[2]/@x",
                "found": "y",
                "allowed": "z, w",
            },
            {
                "severity": "note",
                "rule": "name",
                "text": "name q is used twice",
                "file": "a b/ü.xml",
                "line": 9,
                "xpath": "/a/b",
                "found": None,
                "allowed": None,
            },
        ],
    }
    assert second["valid"] is True
    assert second["findings"][0]["line"] is None


def check_sarif(document: dict[str, Any]) -> list[dict[str, Any]]:
    """Check what SARIF 2.1.0 requires of the parts that are written; return the results."""
    assert document["version"] == "2.1.0"
    assert document["$schema"].endswith("/sarif-2.1.0.json")
    (run,) = document["runs"]
    assert set(run) <= {"tool", "results", "columnKind"}
    assert run["columnKind"] in ("utf16CodeUnits", "unicodeCodePoints")
    driver = run["tool"]["driver"]
    assert driver["name"]
    rules = driver["rules"]
    assert len({rule["id"] for rule in rules}) == len(rules)
    for rule in rules:
        assert set(rule) == {"id", "shortDescription"}
        assert rule["shortDescription"]["text"]
    for result in run["results"]:
        assert set(result) <= {
            "ruleId",
            "ruleIndex",
            "level",
            "message",
            "locations",
            "properties",
        }
        assert rules[result["ruleIndex"]]["id"] == result["ruleId"]
        assert result["level"] in ("none", "note", "warning", "error")
        assert isinstance(result["message"]["text"], str)
        for location in result["locations"]:
            physical = location["physicalLocation"]
            place = physical["artifactLocation"]["uri"]
            assert re.fullmatch(r"[A-Za-z0-9._~!$&'()*+,;=:@/%-]+", place)
            assert not re.search("%(?![0-9A-F]{2})", place)
            assert physical.get("region", {"startLine": 1})["startLine"] >= 1
            for logical in location.get("logicalLocations", ()):
                assert logical["kind"] in ("element", "attribute")
    results: list[dict[str, Any]] = run["results"]
    return results


def test_sarif_is_as_its_readers_want_it() -> None:
    results = check_sarif(json.loads(sarif(ALL, RULES, "rtprofile validate")))
    first = results[0]
    assert first["message"] == {"text": "x is 'y'; allowed: z, w"}
    assert first["properties"] == {"found": "y", "allowed": "z, w"}
    assert first["locations"] == [
        {
            "physicalLocation": {
                "artifactLocation": {"uri": "a%20b/%C3%BC.xml"},
                "region": {"startLine": 3},
            },
            "logicalLocations": [{"fullyQualifiedName": "/a/b[2]/@x", "kind": "attribute"}],
        }
    ]
    assert [result["level"] for result in results] == ["error", "note", "warning", "error", "error"]
    assert "region" not in results[2]["locations"][0]["physicalLocation"]


def test_sarif_can_be_empty() -> None:
    assert check_sarif(json.loads(sarif([GOOD._replace(findings=())], RULES, "t"))) == []


@pytest.mark.parametrize(
    ("file", "shown"),
    [
        ("./a.xml", "a.xml"),
        ("../a:b.xml", "../a%3Ab.xml"),
        ("/tmp/a b#c?.xml", "file:///tmp/a%20b%23c%3F.xml"),
        ("<stdin>", "%3Cstdin%3E"),
        ("a\udcff.xml", "a%FF.xml"),
    ],
)
def test_file_names_are_uris(file: str, shown: str) -> None:
    assert uri(file) == shown


def check_junit(root: Any) -> None:
    """Check the shape that Jenkins, GitLab and Ant have in common, attributes and order."""
    assert root.tag == "testsuites"
    assert not root.attrib
    (suite,) = root
    assert suite.tag == "testsuite"
    needed = {"name", "tests", "failures", "errors", "skipped", "time", "timestamp", "hostname"}
    assert set(suite.attrib) == needed | {"package", "id"}
    assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d", suite.get("timestamp"))
    tags = [child.tag for child in suite]
    cases = suite.findall("testcase")
    assert tags == ["properties", *["testcase"] * len(cases), "system-out", "system-err"]
    failed = 0
    for case in cases:
        assert set(case.attrib) == {"name", "classname", "time"}
        assert [child.tag for child in case] in ([], ["failure"])
        for failure in case:
            failed += 1
            assert set(failure.attrib) == {"type", "message"}
    assert (suite.get("tests"), suite.get("failures")) == (str(len(cases)), str(failed))
    assert suite.get("errors") == "0"


def test_junit_is_as_its_readers_want_it() -> None:
    root = etree.fromstring(junit(ALL, "rtprofile validate", "2025-01-02T03:04:05").encode())
    check_junit(root)
    bad, good, gone, _ = root.iter("testcase")
    assert bad.get("name") == "a b/ü.xml"
    assert bad[0].get("message") == "x is 'y'; allowed: z, w"
    assert bad[0].text.strip() == (
        "a b/ü.xml:3: error: x is 'y'; allowed: z, w [bad-value] /a/b[2]/@x"
    )
    assert len(good) == 0
    assert gone[0].get("type") == "unreadable"
    assert root.findtext(".//system-out") == (
        "a b/ü.xml:9: note: name q is used twice [name] /a/b\nc.xml: warning: odd [other]"
    )


def test_junit_counts_further_errors() -> None:
    text = junit([Checked("x", "", (ERR, ERR))], "t", "2025-01-02T03:04:05")
    root = etree.fromstring(text.encode())
    assert root.find(".//failure").get("message").endswith("(and 1 more)")


def read_command(line: str) -> tuple[str, dict[str, str], str]:
    """Read a workflow command as the runner of GitHub does."""
    match = re.fullmatch(r"::(\w+) ([^\n\r]*?)::([^\n\r]*)", line)
    assert match is not None, line
    properties = dict(pair.split("=", 1) for pair in match[2].split(","))

    def plain(text: str, codes: dict[str, str]) -> str:
        return re.sub("%[0-9A-F]{2}", lambda found: codes[found[0]], text)

    message = {"%25": "%", "%0D": "\r", "%0A": "\n"}
    value = message | {"%3A": ":", "%2C": ","}
    told = {key: plain(text, value) for key, text in properties.items()}
    return match[1], told, plain(match[3], message)


def test_annotations_are_read_as_they_were_meant() -> None:
    lines = list(github_lines(ALL))
    assert lines[0] == (
        "::error file=a b/ü.xml,line=3,title=bad-value::x is 'y'; allowed: z, w (/a/b[2]/@x)"
    )
    assert [read_command(line)[0] for line in lines] == [
        "error",
        "notice",
        "warning",
        "error",
        "error",
    ]
    assert read_command(lines[2])[1] == {"file": "c.xml", "title": "other"}
    level, told, message = read_command(lines[4])
    assert (level, told) == ("error", {"file": NASTY, "line": "1", "title": NASTY})
    assert message.startswith(NASTY)
