"""What a campaign does to whom is drawn from its seed; its law and its table are right."""

from __future__ import annotations

from collections import Counter

import pytest

from campaign.counts import Counts
from campaign.fleet import Setback
from campaign.floors import Floor
from campaign.law import Law
from campaign.layout import PLACES, SLAVES, members
from campaign.report import (
    Conditions,
    document,
    hosts_rows,
    hosts_section,
    percentile,
    rows,
    write,
    write_hosts,
)
from campaign.schedule import DECK, SPACING, Fault, schedule
from campaign.trial import Outcome

FLOORS = (Floor(0.05, "a process"), Floor(1.0, "a manager"))


@pytest.mark.parametrize("seed", range(5))
def test_what_happens_is_drawn_from_the_seed(seed: int) -> None:
    faults = schedule(seed, 200)
    assert faults == schedule(seed, 200)
    assert faults[:40] == schedule(seed, 40)
    assert {fault.kind for fault in faults[: len(DECK)]} == set(DECK)
    for number in range(len(faults)):
        recent = [fault for fault in faults[number : number + SPACING] if fault.slaves]
        hits = Counter(cell for fault in recent for cell in fault.renewed)
        assert max(hits.values(), default=0) <= 5  # the law gives nobody up
    assert {slave for fault in faults for slave in fault.slaves} == set(SLAVES)


def test_seeds_differ() -> None:
    assert schedule(1, 20) != schedule(2, 20)


def test_whom_a_fault_concerns() -> None:
    both = members("c") + members("e")
    assert Fault("kill two slaves", ("c", "e")).renewed == set(both)
    assert Fault("raise", cell=3).renewed == {3}
    assert Fault("kill manager and slave", ("c",)).renewed == {*members("manager"), *members("c")}
    assert Fault("kill the zygote").renewed == Fault("stop a slave", ("a",)).renewed == set()
    assert Fault("stop a slave", ("a",)).held_up == set(members("a"))
    assert len(Fault("kill everything").renewed) == len(PLACES)
    pairs = [Fault(kind, ("c",), 3) for kind in DECK if Fault(kind).is_pair]
    assert [fault.is_total for fault in pairs] == [True, False, True, True, True]
    assert pairs[1].renewed == {*members("manager"), *members("c")}


def test_the_law_is_counted_along() -> None:
    law, fault = Law(), Fault("kill a slave", ("i",))
    waits = [law.longest_wait_s(fault, 100.0 + number) for number in range(5)]
    assert waits == [pytest.approx(0.11 * 2**number) for number in range(5)]
    assert law.room_at_s(fault) == pytest.approx(100.0 + waits[0] + 60.0)
    assert law.room_at_s(Fault("kill a slave", ("h",))) <= 0.0
    assert law.longest_wait_s(Fault("kill the manager"), 106.0) == 0.0
    assert law.room_at_s(fault) > 160.0  # the next manager goes on
    with pytest.raises(AssertionError, match="no room"):
        law.longest_wait_s(fault, 106.0)
    both = Fault("kill manager and slave", ("h",))
    assert law.longest_wait_s(both, 107.0) == pytest.approx(0.11)
    inside = Fault("raise", cell=members("manager")[0])
    assert law.longest_wait_s(inside, 108.0) == pytest.approx(0.11)
    assert law.longest_wait_s(both, 108.0) == pytest.approx(0.22)
    twice = Fault("kill manager and slave, then in the start", ("b",))
    assert law.longest_wait_s(twice, 108.0) == pytest.approx(0.22)
    assert law.longest_wait_s(Fault("kill everything, then in the start"), 108.0) == 0.0
    law.well(109.0)
    assert law.longest_wait_s(both, 140.0) == pytest.approx(0.11)


def test_counts_are_shared(tmp_path) -> None:
    ours = Counts(str(tmp_path / "counts"), is_new=True)
    theirs = Counts(str(tmp_path / "counts"))
    cell, same = theirs.cell(3), ours.cell(3)
    cell.begin()
    cell.execute(20_000_000)
    cell.execute(10_000_000)
    for missing in (0, 4, -2):
        cell.receive(7, missing)
    assert (same.lives, same.executions, same.longest_s) == (1, 2, 0.02)
    assert same.stream(7) == (3, 4, 1)
    assert same.stream(8) == ours.cell(4).stream(7) == (0, 0, 0)
    same.forget()
    assert cell.longest_s == 0.0
    for record in (cell, same):
        record.close()


def test_the_table() -> None:
    times = [number / 100 for number in range(1, 201)]
    assert percentile(times, 0.99) == 1.98
    assert percentile([1.0], 0.99) == 1.0
    outcomes = [Outcome(Fault("exit", ("a",), 1), seconds, 0.05, ()) for seconds in times]
    head, line = rows(outcomes, FLOORS)
    assert len(head) == len(line)
    assert line == ("exit", "200", "1.005 s", "1.980 s", "2.000 s", "0.050 s", "0.050 s")
    conditions = Conditions(1, 60.0, 0.3)
    assert "None was broken." in document(outcomes, FLOORS, conditions)
    bad = Outcome(Fault("raise", cell=1), 1.0, 0.0, ("Cell2 did not go on",))
    assert "- raise Cell1: Cell2 did not go on" in document([bad], FLOORS, conditions)


def test_the_section_on_several_hosts_is_written_beside_the_rest(tmp_path) -> None:
    file, conditions = tmp_path / "campaign.md", Conditions(1, 60.0, 0.3)
    setbacks = [Setback("cut", "robot1", 1.0, ""), Setback("cut", "robot2", 3.0, "")]
    assert hosts_rows(setbacks)[1:] == [("cut", "2", "2.000 s", "3.000 s", "3.000 s")]
    write(file, "# first\n")
    write_hosts(file, hosts_section(setbacks, 2, conditions))
    write(file, "# second\n")
    text = file.read_text()
    assert text.startswith("# second\n\n## Over several hosts\n\n2 faults. Seed 1, ")
    assert "This host and 2 others" in text
    assert "It always came back." in text
    bad = Setback("slow", "robot1", 50.0, "there is no number")
    write_hosts(file, hosts_section([bad], 1, conditions))
    assert "- slow robot1: there is no number" in file.read_text()
    assert file.read_text().count("## Over several hosts") == 1
