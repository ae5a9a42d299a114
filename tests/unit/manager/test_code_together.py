"""The code that some work runs is put together, and does what it did."""

from __future__ import annotations

import gc
import sys
import threading
from collections.abc import Callable, Iterator
from types import CodeType, FunctionType

import pytest

from rtkit.manager.slaves.code_together import put_together

PAGE = 4096
SOURCE = """
def function_{number}(*values, scale=2):
    '''Return what it is called with, and more.'''
    offset = {number}
    times = lambda value: value * scale
    return [times(value) + offset for value in values if value is not None]
"""


@pytest.fixture
def scattered() -> Iterator[list[Callable[..., list[int]]]]:
    """Functions with code that lies among that of others."""
    names: dict[str, FunctionType] = {}
    for number in range(400):
        exec(SOURCE.format(number=number), names)
    yield [names[f"function_{number}"] for number in range(0, 400, 20)]
    gc.unfreeze()


def codes(functions: list[Callable[..., list[int]]]) -> list[CodeType]:
    return [function.__code__ for function in functions]  # type: ignore[attr-defined]


def pages(found: list[CodeType]) -> int:
    return len({id(code) // PAGE for code in found})


def test_it_lies_together_and_does_what_it_did(
    scattered: list[Callable[..., list[int]]],
) -> None:
    before = codes(scattered)
    gc.freeze()

    def work() -> list[list[int]]:
        return [function(1, None, 3, scale=4) for function in scattered]

    expected = work()
    put_together(work)
    after = codes(scattered)
    assert pages(after) < pages(before) / 2
    assert work() == expected
    assert before == after  # by what they do


def test_what_does_not_run_stays_where_it_is(
    scattered: list[Callable[..., list[int]]],
) -> None:
    before = codes(scattered)
    put_together(scattered[3])
    moved = [old is not new for old, new in zip(before, codes(scattered), strict=True)]
    assert moved == [number == 3 for number in range(len(scattered))]


def test_what_shares_code_shares_its_copy() -> None:
    def maker(step: int) -> Callable[[int], int]:
        return lambda value: value + step

    one, two = maker(1), maker(2)
    put_together(lambda: (maker(3), one(0)))
    assert codes([one]) == codes([two])  # type: ignore[list-item]
    assert one.__code__ is two.__code__ is maker(4).__code__  # type: ignore[attr-defined]
    assert (one(1), two(1), maker(4)(1)) == (2, 3, 5)


def test_threads_that_the_work_starts_count(
    scattered: list[Callable[..., list[int]]],
) -> None:
    before = codes(scattered)

    def work() -> None:
        thread = threading.Thread(target=scattered[0], args=(1,))
        thread.start()
        thread.join()

    put_together(work)
    assert codes(scattered)[0] is not before[0]
    assert threading.getprofile() is None


def test_work_that_fails_leaves_no_hook() -> None:
    with pytest.raises(ZeroDivisionError):
        put_together(lambda: 1 / 0)
    assert sys.getprofile() is None
