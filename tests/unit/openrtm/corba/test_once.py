"""Threads that ask for a class of an IDL file at once get the same one."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from threading import Barrier, BrokenBarrierError

from openrtm_files import made, write_component


def test_an_exception_is_one_class_for_all_threads(tmp_path: Path, monkeypatch) -> None:
    from rtkit.openrtm.corba import declared

    both = Barrier(2)
    make = declared.exception_class

    def slowly(declaration):
        with suppress(BrokenBarrierError):
            both.wait(0.2)  # the other one comes here, too, where nothing keeps it off
        return make(declaration)

    monkeypatch.setattr(declared, "exception_class", slowly)
    (tmp_path / "Cell.idl").write_text(
        "module Cell { exception Missing { long number; }; };\n", encoding="utf-8"
    )
    body = "find = staticmethod(lambda: Cell.Missing)"
    file = write_component(tmp_path, "One", body, before="import Cell_idl, Cell\n")
    find = made(file).servant.find
    with ThreadPoolExecutor(2) as pool:
        one, other = [each.result() for each in [pool.submit(find) for _ in range(2)]]
    assert one is other
