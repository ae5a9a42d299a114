"""Scripts that bring a system up, look at it, and take it down."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from shells import Shell

import rtkit
from rtkit.api.tree import Tree
from rtkit.errors import Refused

KEEPS_MANAGER = True
IN, OUT = "/localhost/SeqIn0.rtc", "/localhost/SeqOut0.rtc"


@pytest.fixture
def tree(manager: Shell, monkeypatch: pytest.MonkeyPatch) -> Iterator[Tree]:
    for name, value in manager.environment.items():
        monkeypatch.setenv(name, value)
    with rtkit.connect() as tree:
        yield tree


def test_values_are_read_and_written(tree: Tree) -> None:
    source, sink = tree.create("SeqOut?manager_name=s"), tree.create("SeqIn?manager_name=s")
    tree.activate(source)
    tree.wait(f"{source}:Long", timeout_s=10.0)
    value = tree.read(f"{source}:Long")
    assert isinstance(value.data, int)
    two = list(tree.values(f"{source}:Long", f"{source}:Short", number=2, timeout_s=10.0))
    assert {each.port.partition(":")[0] for each in two} == {source}
    assert abs(two[0].time - time.time()) < 60.0
    assert tree.write(f"{sink}:Long", 1, {"data": 2}, type(value)(data=3)) == 3
    tree.deactivate(source)
    with pytest.raises(TimeoutError, match=r"carried no data for 0\.05 s"):
        tree.read(f"{source}:Long", timeout_s=0.05)
    with pytest.raises(Refused, match="Port is not output"):
        tree.read(f"{sink}:Long")


def test_a_script_reads_several_ports_and_writes_meanwhile(tree: Tree) -> None:
    """Its process is attached once, whatever it reads and writes."""
    source, sink = tree.create("SeqOut?manager_name=s"), tree.create("SeqIn?manager_name=s")
    tree.activate(source)
    first = tree.values(f"{source}:Long", timeout_s=10.0)
    before = next(first)
    files = len(os.listdir("/proc/self/fd"))
    for _ in range(3):
        assert tree.write(f"{sink}:Long", 1) == 1
    second = tree.values(f"{source}:Long", timeout_s=10.0)
    assert next(second).value.data >= before.value.data
    first.close()
    assert next(second).value.data > before.value.data
    second.close()
    assert tree.ls() == ["SeqIn0.rtc", "SeqOut0.rtc", "manager.mgr"]
    assert not any(each.is_guest for each in tree.snapshot().processes)
    assert len(os.listdir("/proc/self/fd")) <= files


def test_a_system_goes_through_its_whole_cycle(tree: Tree, tmp_path: Path) -> None:
    source = tree.create("SeqOut?manager_name=s")
    tree.connect(f"{source}:Long", f"{tree.create('SeqIn?manager_name=other')}:Long")
    file = tmp_path / "robot.xml"
    tree.save("Robot").write(file)
    tree.teardown(file, end=True)
    assert tree.ls() == ["manager.mgr"]
    tree.apply_profile(file, rollback=True)
    tree.wait(IN, OUT, state="active")
    assert tree.check(file)
    tree.stop(file)
    assert [each.kind for each in tree.check(file)] == ["state", "state"]
    tree.start(file)
    tree.teardown(file, end=True)
    assert not tree.check(file)
