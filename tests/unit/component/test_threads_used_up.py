"""No thread can be had: what was asked is refused and undone, and the next time it works."""

from __future__ import annotations

import threading

import pytest

from rtkit.component.contexts.context import ExecutionContext
from rtkit.container.pacer import Pacer
from rtkit.errors import Refused
from rtkit.rtc.enums import ExecutionKind


@pytest.fixture
def context() -> ExecutionContext:
    return ExecutionContext("0", ExecutionKind.PERIODIC, 1000.0, "A")


def test_what_is_refused_is_never_done(
    context: ExecutionContext, monkeypatch: pytest.MonkeyPatch
) -> None:
    done = threading.Event()
    refused = threading.Event()
    pacer = Pacer(context, "A")

    def start(_: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    with monkeypatch.context() as patch:
        patch.setattr(threading.Thread, "start", start)
        with pytest.raises(Refused, match="no thread can be had for A: can't start new thread"):
            context.submit(refused.set)
        context.set_rate(10.0)  # which is noted all the same
    assert context.rate == 10.0
    context.submit(done.set)
    assert done.wait(10.0)
    assert pacer.close(10.0)
    assert not refused.is_set()
