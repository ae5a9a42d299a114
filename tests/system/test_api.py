"""Scripts that bring a system up, look at it, and take it down."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from shells import Shell

import rtkit
from rtkit.api.tree import Tree
from rtkit.errors import NotFound, Refused, Unreachable

KEEPS_MANAGER = True
IN, OUT = "/localhost/SeqIn0.rtc", "/localhost/SeqOut0.rtc"


@pytest.fixture
def tree(manager: Shell, monkeypatch: pytest.MonkeyPatch) -> Iterator[Tree]:
    for name, value in manager.environment.items():
        monkeypatch.setenv(name, value)
    with rtkit.connect() as tree:
        yield tree


def test_a_closed_client_leaves_no_thread_that_would_abort_its_process(tree: Tree) -> None:
    before = {*threading.enumerate()}
    client = rtkit.Client()
    assert client.get("/localhost/manager.mgr.name") == "manager"
    client.close()
    assert not {each.name for each in threading.enumerate() if each not in before}


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
    (named,) = tree.values("SeqOut*:Long", number=1, timeout_s=10.0)
    assert named.port == f"{source}:Long"
    assert tree.write("SeqIn*:Long", 4) == 1
    with pytest.raises(NotFound, match=r"No output port matches: Nobody\*:Long"):
        tree.read("Nobody*:Long")
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


def test_a_script_calls_and_observes(tree: Tree) -> None:
    source = tree.create("SeqOut?manager_name=s")
    with tree.live() as live, closing(tree.events(source, kinds=["RTC_STATUS"])) as events:
        tree.properties.set(f"{source}.state", "Active")
        assert (next(events).event, tree.properties.get(f"{source}.state")) == ("ACTIVE", "Active")
        while not any(each.state == "Active" for each in live.facts.components):
            assert live.wait(10.0)
    with closing(tree.properties.listen(f"{source}.state", timeout_s=10.0)) as changes:
        assert next(changes).value == "Active"
        tree.deactivate(source)
        assert next(changes).value == "Inactive"
    service = tree.create("MyServiceProvider?manager_name=s")
    assert tree.call(f"{service}:myservice.echo", "hello") == "hello"
    assert tree.call(f"{service}:myservice.set_value", 2.5) is None
    assert tree.call(f"{service}:myservice.get_value") == 2.5
    with pytest.raises(NotFound, match=r"no operation ech of .*did you mean echo"):
        tree.call(f"{service}:myservice.ech")
    began = [each.process for each in tree.logs(level="INFO", text="begins")]
    assert began == ["manager", "s"]
    with closing(tree.logs(level="DEBUG", last=0, follow=True, timeout_s=10.0)) as coming:
        tree.create("SeqIn?manager_name=t")
        assert next(each for each in coming if each.process == "t")


def test_a_system_may_be_in_several_managers(tree: Tree, tmp_path: Path) -> None:
    """The other one is started, connected to, and told what concerns it."""
    file = tmp_path / "robot.xml"
    for name in ("SeqOut", "SeqIn"):
        tree.create(name)
    tree.save("Robot", unconnected=True).write(file)
    tree.teardown(file, end=True)
    text = file.read_text()
    file.write_text(text.replace("localhost/SeqIn0.rtc", "localhost/other.mgr/SeqIn0.rtc"))
    plan = tree.plan(file)
    assert plan.steps[0] == "start manager other"
    plan.apply()
    with rtkit.connect("other") as other:
        assert [each.instance for each in other.snapshot().components] == ["SeqIn0"]
        assert tree.check(file)
        tree.teardown(file, end=True)
        assert other.snapshot().components == ()
        other.stop_manager()
    with pytest.raises(Unreachable):
        rtkit.connect("other")
