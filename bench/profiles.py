"""Measures reading profiles, repairs and checks included, against lxml's parse and validation."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from lxml import etree

from bench.harness import Lines, Row, timed
from bench.pairs import medians, paired, pairs_of
from bench.synthetic import system
from rtkit.profile.forms import FORMS
from rtkit.profile.read import read_profile
from rtkit.profile.rts_model import RtsProfile
from rtkit.profile.write import write_profile
from rtkit.resources import resource

CORPUS = Path(__file__).resolve().parents[2] / "shared" / "corpus"
_FLOOR_IS = "lxml: parse, validate by the same schema"
_ROUNDS = 7

_MEMORY = """
import gc, sys
from lxml import etree
from rtkit.profile.read import read_profile
from rtkit.resources import resource

def told(key):
    lines = open("/proc/self/status")
    return next(int(line.split()[1]) * 1024 for line in lines if line.startswith(key))

file, small, schema, who = sys.argv[1:]
data, first = open(file, "rb").read(), open(small, "rb").read()
validate = etree.XMLSchema(file=resource("schemas", schema)).validate
read = read_profile if who == "rtkit" else lambda data: validate(etree.fromstring(data))
read(first)
gc.collect()
open("/proc/self/clear_refs", "w").write("5")
before = told("VmRSS:")
kept = read(data)
print((told("VmHWM:") - before) / len(data))
"""


def _read() -> Lines:
    largest = _largest()
    if largest is not None:
        what = f"largest profile of the corpus ({len(largest.read_bytes()) / 1e3:.0f} kB), read"
        data = largest.read_bytes()
        measured = paired(_reading(data), _floor(data))
        yield Row(what, "ms", measured, 5.0, True, _FLOOR_IS)
    profile = system(1000, 5000)
    yield from _large(profile)
    yield from _others(profile)
    yield _memory(profile)


PARTS = {"read": _read}


def _large(profile: RtsProfile) -> Iterator[Row]:
    data = write_profile(profile)
    what = f"1,000 components, 5,000 connectors ({len(data) / 1e6:.1f} MB)"
    pairs = pairs_of(_reading(data), _floor(data), _ROUNDS)
    yield Row(f"{what}, read", "ms", medians(pairs), 5.0, True, _FLOOR_IS)
    yield Row(f"{what}, read, at most 1 s", "ms", medians(pairs), 1000.0, False, _FLOOR_IS)
    lenient = data.replace(b' rtsExt:direction="RIGHT"', b' rtsExt:direction="right"')
    pairs = pairs_of(_reading(lenient), _floor(data), _ROUNDS)
    yield Row(f"{what}, 1,000 repairs, read", "ms", medians(pairs), None, True, _FLOOR_IS)
    pairs = pairs_of(lambda: timed(lambda: write_profile(profile)), _floor(data), _ROUNDS)
    yield Row(f"{what}, written", "ms", medians(pairs), None, True, _FLOOR_IS)


def _others(profile: RtsProfile) -> Iterator[Row]:
    """The other forms, beside the bare library that parses them."""
    import json

    import yaml

    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    libraries: dict[str, Callable[[bytes], Any]] = {
        "yaml": lambda data: yaml.load(data, Loader=loader),
        "json": json.loads,
    }
    for form in FORMS:
        library = libraries.get(form)
        if library is None:
            continue
        data = write_profile(profile, form)
        what = f"the same as {form.upper()} ({len(data) / 1e6:.1f} MB), read"
        measured = paired(_reading(data), _calls(library, data), 3)
        yield Row(what, "ms", measured, None, True, f"{library.__module__}: parse alone")


def _memory(profile: RtsProfile) -> Row:
    """Growth of a process at its peak, in sizes of the file, all imports and schemas there."""
    with tempfile.TemporaryDirectory(prefix="rtb") as folder:
        large, small = Path(folder) / "large.xml", Path(folder) / "small.xml"
        large.write_bytes(write_profile(profile))
        small.write_bytes(write_profile(system(2, 2)))

        def grown(who: str) -> float:
            command = [sys.executable, "-c", _MEMORY, str(large), str(small), "RtsProfile.xsd", who]
            done = subprocess.run(command, capture_output=True, text=True, check=True)
            return float(done.stdout)

        measured = paired(lambda: grown("rtkit"), lambda: grown("lxml"), 3)
    what = "memory to read it, at its peak, in sizes of the file"
    return Row(what, "x", measured, 10.0, False, _FLOOR_IS)


def _largest() -> Path | None:
    files = [file for kind in ("rtc", "rts") for file in (CORPUS / kind).glob("*")]
    return max(files, key=os.path.getsize, default=None)


def _reading(data: bytes) -> Callable[[], float]:
    return lambda: timed(lambda: read_profile(data))


def _floor(data: bytes) -> Callable[[], float]:
    kind = "Rts" if b"RtsProfile" in data else "Rtc"
    schema = etree.XMLSchema(file=resource("schemas", f"{kind}Profile.xsd"))
    return lambda: timed(lambda: schema.validate(etree.fromstring(data)))


def _calls(library: Callable[[bytes], Any], data: bytes) -> Callable[[], float]:
    return lambda: timed(lambda: library(data))
