"""``rtcomp`` on real processes: members come, work together, and go."""

from __future__ import annotations

from typing import Any

import pytest

KEEPS_MANAGER = True
MANAGER = "/localhost/manager.mgr"
WHOLE = "/localhost/Whole.rtc"


@pytest.fixture
def robot(manager: Any) -> Any:
    """A manager whose slave holds two SeqIn and a SeqOut."""
    line = "-c SeqOut?manager_name=robot -c SeqIn?manager_name=robot -c SeqIn?manager_name=robot"
    manager.ok(f"rtmgr {line} -c ConsoleOut {MANAGER}")
    return manager


def states(shell: Any) -> dict[str, str]:
    lines = [line.split() for line in shell.ok(f"rtls -l {MANAGER}").splitlines()]
    return {line[5].removesuffix(".rtc"): line[0] for line in lines if line[5].endswith(".rtc")}


def test_members_work_as_one(robot: Any) -> None:
    robot.ok(
        f"rtcomp -a /localhost/SeqOut0.rtc:Long,Short -a /localhost/SeqIn0.rtc {MANAGER}:Whole"
    )
    assert robot.ok(f"rtls {MANAGER}/robot.mgr").split() == [
        "SeqIn0.rtc",
        "SeqIn1.rtc",
        "SeqOut0.rtc",
        "Whole.rtc",
    ]
    robot.ok(f"rtcon {WHOLE}:SeqOut0.Long /localhost/SeqIn1.rtc:Long")
    robot.ok(f"rtact {WHOLE}")
    assert states(robot) == {
        "ConsoleOut0": "Inactive",
        "SeqIn0": "Active",
        "SeqIn1": "Inactive",
        "SeqOut0": "Active",
        "Whole": "Active",
    }
    robot.ok(f"rtdeact {WHOLE}")
    assert set(states(robot).values()) == {"Inactive"}


def test_members_and_ports_come_and_go(robot: Any) -> None:
    robot.ok(f"rtcomp {MANAGER}/robot.mgr:Whole")
    robot.ok(f"rtcomp -a /localhost/SeqOut0.rtc:Long {WHOLE}")
    robot.ok(f"rtcomp -a /localhost/SeqOut0.rtc:Short -a /localhost/SeqIn0.rtc {MANAGER}:Whole")
    assert robot.ok(f"rtls -l {WHOLE}").split() == [
        "Inactive",
        *["2/0", "0/0", "2/0", "0/0"],
        "Whole.rtc",
    ]
    robot.ok(f"rtcomp -r /localhost/SeqOut0.rtc:Long {WHOLE}")
    assert robot.ok(f"rtcat {WHOLE}:SeqOut0.Short") == "+DataOutPort: SeqOut0.Short\n"
    missing = f"rtcat: Port not found: {WHOLE}:SeqOut0.Long (did you mean SeqOut0.Short?)\n"
    assert robot.run(f"rtcat {WHOLE}:SeqOut0.Long") == (1, "", missing)
    robot.ok("rtexit /localhost/SeqOut0.rtc")
    robot.ok(f"rtcomp -r /localhost/SeqOut0.rtc -r /localhost/SeqIn0.rtc {WHOLE}")
    assert robot.ok(f"rtconf -l -s default {WHOLE}").split() == [
        "-default*",
        "exported_ports",
        "members",
    ]
    assert "  Type           Composite\n" in robot.ok(f"rtcat {WHOLE}")
    robot.ok("rtact /localhost/SeqIn0.rtc")


def test_what_cannot_be_changes_nothing(robot: Any) -> None:
    robot.ok(f"rtcomp -a /localhost/SeqIn0.rtc {MANAGER}:Whole")
    before = robot.ok(f"rtcat -ll {WHOLE}")
    for arguments, why in (
        (f"-a /localhost/ConsoleOut0.rtc {WHOLE}", "ConsoleOut0.rtc is in manager, Whole in robot"),
        (f"-a /localhost/SeqIn1.rtc:No {WHOLE}", "Port not found: /localhost/SeqIn1.rtc:No"),
        (f"-a {WHOLE} {WHOLE}", "cannot be a member of itself"),
        (f"-a /localhost/SeqIn0.rtc {MANAGER}:Other", "SeqIn0 is a member of Whole already"),
        (f"-a /localhost/SeqIn1.rtc {MANAGER}:SeqOut0", "Not a composite component"),
    ):
        status, out, err = robot.run(f"rtcomp {arguments}")
        assert (status, out) == (1, "")
        assert why in err
        assert err.count("\n") == 1
    assert robot.ok(f"rtcat -ll {WHOLE}") == before
    assert robot.run("rtls /localhost/Other.rtc").status == 1


def test_composites_of_composites(robot: Any) -> None:
    robot.ok(f"rtcomp -a /localhost/SeqOut0.rtc:Long {MANAGER}:Inner")
    robot.ok(
        f"rtcomp -a /localhost/Inner.rtc:SeqOut0.Long -a /localhost/SeqIn0.rtc {MANAGER}:Whole"
    )
    assert "  Type           Composite composite member\n" in robot.ok("rtcat /localhost/Inner.rtc")
    robot.ok(f"rtact {WHOLE}")
    assert [states(robot)[name] for name in ("Inner", "SeqOut0", "SeqIn0")] == ["Active"] * 3
    assert robot.ok(f"rtcat {WHOLE}:Inner.SeqOut0.Long") == "+DataOutPort: Inner.SeqOut0.Long\n"
