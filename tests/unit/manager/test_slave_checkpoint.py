"""What a slave writes down of what it holds is what can be read, whatever befalls it."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from rtkit.container.slave_checkpoint import CheckpointWriter, SlaveCheckpoint, read_checkpoint


def record(instance: str, text: str = "") -> dict[str, str]:
    return {"instance": instance, "text": text}


def test_it_says_what_is_there_as_it_was_last(tmp_path: Path) -> None:
    path = str(tmp_path / "held")
    checkpoint_writer = CheckpointWriter(path, "s")
    assert read_checkpoint(path) == SlaveCheckpoint("s", [])
    for instance in "ABC":
        checkpoint_writer.keep(instance, record(instance))
    checkpoint_writer.keep("A", record("A", "later"))
    checkpoint_writer.strike("B")
    checkpoint_writer.strike("never")
    assert read_checkpoint(path) == SlaveCheckpoint("s", [record("A", "later"), record("C")])


def test_it_does_not_grow_with_its_changes(tmp_path: Path) -> None:
    path = str(tmp_path / "held")
    checkpoint_writer = CheckpointWriter(path, "s")
    checkpoint_writer.keep("B", record("B"))
    for number in range(3000):
        checkpoint_writer.keep("A", record("A", f"{number:>200}"))
        assert os.stat(path).st_size < 100_000
    assert read_checkpoint(path) == SlaveCheckpoint("s", [record("B"), record("A", f"{2999:>200}")])
    assert os.listdir(tmp_path) == ["held"]


def test_what_was_cut_off_while_it_was_written_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "held"
    checkpoint_writer = CheckpointWriter(str(path), "s")
    checkpoint_writer.keep("A", record("A"))
    checkpoint_writer.keep("B", record("B"))
    whole = path.read_bytes()
    first = len(b'{"slave":"s"}\n')
    for size in range(len(whole)):
        path.write_bytes(whole[:size])
        checkpoint = read_checkpoint(str(path))
        assert (checkpoint is None) == (size < first - 1), size
        assert checkpoint is None or all(
            each in (record("A"), record("B")) for each in checkpoint[1]
        )


@pytest.mark.parametrize("text", ["", "{", "[]", "3\n", '{"slave":"s"}\n[]\n{"gone":[]}\n{}\n3'])
def test_what_is_no_will(tmp_path: Path, text: str) -> None:
    (tmp_path / "held").write_text(text)
    assert read_checkpoint(str(tmp_path / "held")) in (None, SlaveCheckpoint("s", []))


def test_a_folder_in_which_nothing_can_be_written_stops_nobody(tmp_path: Path) -> None:
    checkpoint_writer = CheckpointWriter(str(tmp_path / "no" / "held"), "s")
    checkpoint_writer.keep("A", record("A"))
    checkpoint_writer.strike("A")
