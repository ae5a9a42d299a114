"""Measures managers over mutual TLS: a request, a listing, the first value of a port."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial

from bench.harness import Lines, Row, command, create, folders, process, timed
from bench.pairs import paired
from rtkit.keys import authority
from rtkit.tree import managers
from rtkit.tree.client import Tree
from rtkit.tree.connect import connect

_AT = "127.0.0.2"
_REQUESTS = 10
"""At a time; more than 500 a second are refused."""
_PAUSE_S = 0.05
_LOCAL_IS = "the same over the Unix socket"


@contextmanager
def _manager() -> Iterator[str]:
    """Start a manager with ten components and a port for certificates; yield its address."""
    with folders() as base:
        os.environ["RTKIT_KEYS"] = os.path.join(base, "keys")
        authority.init("bench", [_AT])
        process([command("rtmgr"), "start", "--no-door", "--tls", f"{_AT}:0"])
        try:
            with connect() as tree:
                create(tree, [f"ConsoleIn?instance_name=N{index}" for index in range(10)])
                process([command("rtact"), "/localhost/N0.rtc"])
                address = tree.get("rtkit.tls_address")
            yield address
        finally:
            managers.stop("manager", 10.0)
            del os.environ["RTKIT_KEYS"]


def _requests(tree: Tree) -> float:
    time.sleep(_PAUSE_S)
    return timed(lambda: [tree.get("manager.pid") for _ in range(_REQUESTS)]) / _REQUESTS * 1e3


def _secure() -> Lines:
    with _manager() as address:
        with connect(address) as far, connect() as near:
            figures = paired(lambda: _requests(far), lambda: _requests(near))
            yield Row("a request over TLS", "us", figures, None, False, _LOCAL_IS)
        for what, words in (
            ("rtls of 10 components over TLS, whole process", ["rtls", "{}"]),
            ("rtprint -n 1 over TLS, whole process", ["rtprint", "-n", "1", "{}/N0.rtc:out"]),
        ):
            name, *rest = words

            def run(place: str, name: str = name, rest: list[str] = rest) -> float:
                return process([command(name), *(each.format(place) for each in rest)])

            figures = paired(partial(run, f"/{address}"), partial(run, "/localhost"))
            yield Row(what, "ms", figures, None, False, _LOCAL_IS)


PARTS = {"tls": _secure}
