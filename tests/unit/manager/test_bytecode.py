"""Byte code is kept beside modules, believed only of this very source, and never needed."""

from __future__ import annotations

import importlib.util
import os
import sys
import time

import pytest

from rtkit.modules.bytecode import code_of


@pytest.fixture(autouse=True)
def _keeping(monkeypatch):
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    monkeypatch.setattr(sys, "pycache_prefix", None)


@pytest.fixture
def module(tmp_path):
    return tmp_path / "Thing.py"


def value_of(module, source):
    module.write_bytes(source)
    names = {}
    exec(code_of(str(module), source), names)
    return names["value"]


def kept(module):
    folder = module.parent / "__pycache__"
    return sorted(folder.iterdir()) if folder.exists() else []


def test_what_is_kept_is_taken(module):
    assert value_of(module, b"value = 1") == 1
    (file,) = kept(module)
    head, body = file.read_bytes()[:16], file.read_bytes()[16:]
    import marshal

    other = compile("value = 'kept'", str(module), "exec")
    file.write_bytes(head + marshal.dumps(other))
    assert value_of(module, b"value = 1") == "kept"
    assert body != marshal.dumps(other)


def test_another_source_of_the_same_size_at_the_same_time_is_compiled_anew(module):
    now = time.time()
    for number in b"1", b"2", b"1":
        module.write_bytes(b"value = " + number)
        os.utime(module, (now, now))
        names = {}
        exec(code_of(str(module), b"value = " + number), names)
        assert names["value"] == int(number)


def test_python_itself_takes_what_is_kept(module):
    value_of(module, b"value = 1")
    loader = importlib.util.spec_from_file_location("Thing", module).loader
    before = kept(module)[0].stat()
    assert loader.get_code("Thing") is not None
    after = kept(module)[0].stat()
    assert (before.st_ino, before.st_mtime_ns) == (after.st_ino, after.st_mtime_ns)


@pytest.mark.parametrize("length", [0, 8, 16, 30])
def test_half_a_file_is_compiled_anew(module, length):
    value_of(module, b"value = 1")
    (file,) = kept(module)
    whole = file.read_bytes()
    file.write_bytes(whole[:length])
    assert value_of(module, b"value = 1") == 1
    assert kept(module)[0].read_bytes() == whole


def test_what_everybody_may_write_is_not_believed(module):
    value_of(module, b"value = 1")
    (file,) = kept(module)
    file.write_bytes(file.read_bytes().replace(b"value", b"other"))
    file.chmod(0o666)
    assert value_of(module, b"value = 1") == 1


def test_a_module_that_moved_tells_its_new_place(module):
    value_of(module, b"value = 1")
    moved = module.parent / "moved"
    moved.mkdir()
    os.rename(module.parent / "__pycache__", moved / "__pycache__")
    file = moved / "Thing.py"
    assert code_of(str(file), b"value = 1").co_filename == str(file)


def test_nothing_is_kept_where_it_is_not_to_be(module, monkeypatch):
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    assert value_of(module, b"value = 1") == 1
    assert kept(module) == []


def test_a_place_that_cannot_be_written_costs_nothing_but_time(module):
    (module.parent / "__pycache__").write_text("no folder")
    assert value_of(module, b"value = 1") == 1


def test_a_module_is_compiled_as_it_stands(module):
    source = b"def f(x: int): pass\nvalue = f.__annotations__['x']"
    assert value_of(module, source) is int
