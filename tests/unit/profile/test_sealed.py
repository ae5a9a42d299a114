"""Reading in a process to which the kernel allows no file, socket or program, and little memory.

What a library does below Python cannot be seen from Python: here such a call ends the process.
"""

from __future__ import annotations

import json
import platform
import random
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
SAMPLES = Path(__file__).parent / "samples"
WORDS = (ROOT / "tests" / "laws" / "hostile_words.txt").read_bytes().splitlines()
CALLS = {
    "x86_64": {"openat": 257, "open": 2, "openat2": 437, "socket": 41, "execve": 59, "fork": 57},
    "aarch64": {"openat": 56, "openat2": 437, "socket": 198, "execve": 221},
}
MEGABYTES = 200
"""How much a process may grow over reading documents of at most 12 MiB, one after the other."""

SUPPORT = str(Path(__file__).parents[2] / "support")
CHILD = (
    f"import sys; sys.path.append({SUPPORT!r})"
    + """
import ctypes, gc, json, struct, sys
from rtkit.profile.findings import InvalidProfile
from rtkit.profile.examine import examine
from profile_reading import explain
from rtkit.profile.read import read_profile

calls, how, size = json.loads(sys.argv[1]), sys.argv[2], struct.Struct(">I")

def verdict(data):
    if how == "explain":
        return "notes" if explain(data) else "fine"
    if how == "examine":
        return "notes" if examine(data).repairs else "fine"
    try:
        return "notes" if read_profile(data).notes else "fine"
    except InvalidProfile as refused:
        return "refused: " + refused.problems[0].rule

def documents():
    while head := sys.stdin.buffer.read(4):
        yield sys.stdin.buffer.read(size.unpack(head)[0])

def seal():
    # For each call: load its number, end the process if it is one of these, else allow it.
    rules = [(0x20, 0, 0, 0)] + [(0x15, len(calls) - n, 0, c) for n, c in enumerate(calls)]
    rules += [(0x06, 0, 0, 0x7FFF0000), (0x06, 0, 0, 0x80000000)]
    code = b"".join(struct.pack("HBBI", *rule) for rule in rules)
    libc = ctypes.CDLL(None, use_errno=True)
    text = ctypes.create_string_buffer(code, len(code))
    program = struct.pack("HxxxxxxP", len(rules), ctypes.addressof(text))
    assert libc.prctl(38, 1, 0, 0, 0) == 0
    return libc.prctl(22, 2, ctypes.c_char_p(program)) == 0

def told(key):
    return next(int(line.split()[1]) for line in status() if line.startswith(key))

source = open("/proc/self/status")
def status():
    source.seek(0)
    return source.readlines()

stream = documents()
for _ in range(int(sys.argv[3])):
    verdict(next(stream))
gc.collect()
before = told("VmRSS:")
print(json.dumps({"sealed": seal()}), flush=True)
for data in stream:
    print(json.dumps({"is": verdict(data), "grown": (told("VmHWM:") - before) // 1024}), flush=True)
open("/dev/null")
print(json.dumps({"sealed": False}))
"""
)


def warm_up() -> list[bytes]:
    """Documents that have the readers import all they ever need: good ones and bad ones."""
    files = [
        SAMPLES / f"{kind}.{form}" for kind in ("rtc", "rts") for form in ("xml", "yaml", "json")
    ]
    good = [file.read_bytes() for file in files]
    bad = [data.replace(b"PERIODIC", b"PERIODOC").replace(b"LEFT", b"left") for data in good]
    worse = [data.replace(b"instanceName", b"x").replace(b"matchCase", b"y") for data in good]
    return [*good, *bad, *worse, *(data[:-9] for data in good), b"\xff", b"\xff\xfe\0", b""]


def hostile() -> Iterator[bytes]:
    many = 11 * 2**20
    head = b'<RtsProfile xmlns="http://www.openrtp.org/namespaces/rts" '
    key = b"rtsProfile: "
    yield b'<!DOCTYPE d SYSTEM "/etc/passwd"><d/>'
    yield b'<!DOCTYPE d [<!ENTITY % x SYSTEM "http://127.0.0.1:9/x">%x;]><d>&x;</d>'
    yield b'<!DOCTYPE d [<!ENTITY a "' + b"a" * many + b'">]><d>&a;</d>'
    yield head + b'id="' + b"a" * many + b'"/>'
    yield head + b" ".join(b"a%d=''" % n for n in range(200_000)) + b"/>"
    yield head + b">" + b"<a>" * 100_000
    yield (
        head
        + b'><x:include xmlns:x="http://www.w3.org/2001/XInclude" href="/etc/passwd"/></RtsProfile>'
    )
    yield (
        head
        + b'xmlns:i="http://www.w3.org/2001/XMLSchema-instance" i:schemaLocation="x /etc/passwd"/>'
    )
    yield b'<?xml-stylesheet href="/etc/passwd"?>' + head + b"/>"
    yield b"[" * many
    yield b"{" + b'"a":{' * 100_000
    yield b'{"rtsProfile": "' + b"a" * many + b'"}'
    yield b'{"rtsProfile": [' + b"1," * (many // 2) + b"1]}"
    yield b'{"rtsProfile": ' + b"9" * many + b"}"
    yield key + b"[" * many
    yield key + b"- " * 100_000
    yield key + b'"' + b"a" * many + b'"'
    yield key + b"[" + b"a," * (many // 2) + b"]"
    yield b"a: &a [x]\n" + b"".join(b"b%d: &b%d [*a,*a]\n" % (n, n) for n in range(100)) + key
    yield b"- &a " + b"x" * 2**20 + b"\n" + b"- *a\n" * 100_000 + key
    yield key + b"!!python/object/apply:os.system ['true']"
    yield key + b"!!python/name:os.system"
    yield key + b"\0"


def tedious() -> Iterator[bytes]:
    """Documents that may be read, and that took time by the square of their length once."""
    rts, ext = (b"http://www.openrtp.org/namespaces/rts" + end for end in (b"", b"_ext"))
    date = b"2020-01-01T00:00:00"
    head = b'<RtsProfile xmlns="%s" xmlns:e="%s" id="i" version="0.2" ' % (rts, ext)
    head += b'creationDate="%s" updateDate="%s">' % (date, date)
    part = b'<Components id="a" pathUri="" instanceName="b" isRequired="true">%s</Components>'
    end = b'Port componentId="a" instanceName="b" portName="p%d"/>'
    wire = (
        b"<DataPortConnectors%s><sourceData" + end + b"<targetData" + end + b"</DataPortConnectors>"
    )
    many = range(10_000)
    yield head + part % (b"<ExecutionContexts/>" * 40_000) + b"</RtsProfile>"
    yield head + part % b"" + b"".join(wire % (b"", n, -n) for n in many) + b"</RtsProfile>"
    same = b' connectorId="c"'
    yield head + part % b"" + b"".join(wire % (same, 0, 0) for _ in many) + b"</RtsProfile>"
    yield (
        head + part % b"" + b'<f:a xmlns:f="urn:f"/>' * 900 + b"<e:a/>" * 100_000 + b"</RtsProfile>"
    )
    late = b"<e:a/>" * 90_000 + part % (b"<ExecutionContexts/>" * 20_000)
    yield head + late + b"</RtsProfile>"
    yield head + late.replace(b"/><Ex", b"/>\n<Ex") + b"</RtsProfile>"
    yield head + b'<e:a b="' + b"\n" * 10**6 + b'"/>' + late + b"</RtsProfile>"
    rtc = head.replace(b"/rts", b"/rtc").replace(b"RtsProfile", b"RtcProfile")
    configurations = b"<ConfigurationSet>" + b"<Configuration/>" * 40_000 + b"</ConfigurationSet>"
    yield rtc + configurations + b"<e:a/>" * 40_000 + b"</RtcProfile>"
    keys = b", ".join(b'"{urn:f}%d": x' % n for n in range(100_000))
    yield b"rtsProfile: {id: i, foreign::attributes: {%s}}" % keys
    yield b"rtsProfile: {id: i, %s}" % keys.replace(b"{urn:f}", b"a")
    yield b"rtsProfile: {id: i, e: [%s]}" % (b"{}, " * 40_000)


def damaged(count: int) -> Iterator[bytes]:
    """The samples with a few words of syntax put in or parts cut out; always the same ones."""
    dice = random.Random(20241)
    good = warm_up()[:6]
    for _ in range(count):
        data = dice.choice(good)
        for _ in range(dice.randint(1, 4)):
            at = dice.randrange(len(data))
            word = dice.choice(WORDS) if dice.random() < 0.8 else dice.randbytes(3)
            data = data[:at] + word + data[at + dice.choice((0, 0, 1, 40)) :]
        yield data


def sealed(documents: list[bytes], how: str) -> list[dict[str, object]]:
    if platform.machine() not in CALLS or sys.platform != "linux":
        pytest.skip("needs system call filters of a known machine")
    first = warm_up()
    calls = sorted(CALLS[platform.machine()].values())
    given = b"".join(len(data).to_bytes(4, "big") + data for data in [*first, *documents])
    done = subprocess.run(
        [sys.executable, "-c", CHILD, json.dumps(calls), how, str(len(first))],
        input=given,
        capture_output=True,
        cwd=ROOT,
        check=False,
    )
    answers = [json.loads(line) for line in done.stdout.splitlines()]
    if answers and answers[0] == {"sealed": False}:
        pytest.skip("system call filters are not allowed here")
    told = done.stderr.decode(errors="replace")
    assert len(answers) == 1 + len(documents), (
        f"ended at {documents[len(answers) - 1][:200]!r}: {told}"
    )
    assert done.returncode == -31, f"the seal did not hold: {told}"
    return answers[1:]


def test_nothing_hostile_opens_anything_or_grows() -> None:
    documents = list(hostile())
    answers = sealed(documents, "read")
    told = [str(answer["is"]) for answer in answers]
    assert told[:3] == ["refused: doctype"] * 3
    assert told[-3:] == ["refused: tag-or-alias"] * 2 + ["refused: not-well-formed"]
    assert [n for n, text in enumerate(told) if not text.startswith("refused")] == []
    assert max(int(str(answer["grown"])) for answer in answers) < MEGABYTES


@pytest.mark.timeout(300)
def test_nothing_takes_the_square_of_its_length() -> None:
    """The time limit of the tests tells."""
    answers = sealed(list(tedious()), "read")
    told = [str(answer["is"]) for answer in answers]
    assert told == ["notes"] * 8 + ["refused: too-many-attributes"] * 2 + ["notes"]
    assert max(int(str(answer["grown"])) for answer in answers) < 2 * MEGABYTES


@pytest.mark.timeout(300)
def test_examining_takes_no_square_either() -> None:
    answers = sealed(list(tedious()), "examine")
    assert {answer["is"] for answer in answers} == {"notes"}


def test_nothing_damaged_opens_anything() -> None:
    documents = list(damaged(1500))
    told = {str(answer["is"]) for answer in sealed(documents, "read")}
    assert "notes" in told
    assert len(told) > 8


def test_explanations_open_nothing() -> None:
    answers = sealed(list(damaged(150)), "explain")
    assert {str(answer["is"]) for answer in answers} == {"fine", "notes"}
