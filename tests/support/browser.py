"""Drives a real headless browser over its debugging pipe."""

from __future__ import annotations

import fcntl
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

NAME = shutil.which("chromium")
_OPTIONS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--disable-dev-shm-usage", "--remote-debugging-pipe",
)  # fmt: skip
_AS_3_AND_4 = """
import os, sys
os.dup2(int(sys.argv[1]), 3)
os.dup2(int(sys.argv[2]), 4)
os.execv(sys.argv[3], sys.argv[3:])
"""


class Browser:
    """One page. `user` and `password` are given to whoever asks for them, in one scheme: Digest."""

    def __init__(self, told: int, tells: int, user: str, password: str) -> None:
        self._out = os.fdopen(told, "wb", buffering=0)
        self._in = os.fdopen(tells, "rb")
        self._credentials = {"username": user, "password": password}
        self._id = 0
        self._session = ""
        target = self._do("Target.createTarget", url="about:blank")["targetId"]
        attached = self._do("Target.attachToTarget", targetId=target, flatten=True)
        self._session = attached["sessionId"]
        self._do("Fetch.enable", handleAuthRequests=True)
        self._do("Page.enable")

    def go(self, url: str) -> None:
        """Open a page."""
        self._do("Page.navigate", url=url)

    def wait_for(self, condition: str) -> None:
        """Wait until an expression of the page is true, as often as something in it changes."""
        self._do(
            "Runtime.evaluate",
            awaitPromise=True,
            expression=f"""new Promise((done) => {{
            const look = () => {{ if ({condition}) {{ watcher.disconnect(); done(true); }} }};
            const watcher = new MutationObserver(look);
            watcher.observe(document, {{subtree: true, childList: true, characterData: true}});
            look();
        }})""",
        )

    def evaluate(self, expression: str) -> Any:
        """Return what an expression of the page is."""
        return self._do("Runtime.evaluate", expression=expression)["result"].get("value")

    def _send(self, method: str, **given: Any) -> int:
        self._id += 1
        message: dict[str, Any] = {"id": self._id, "method": method, "params": given}
        if self._session:
            message["sessionId"] = self._session
        self._out.write(json.dumps(message).encode() + b"\0")
        return self._id

    def _do(self, method: str, **given: Any) -> Any:
        id = self._send(method, **given)
        while (message := self._next()).get("id") != id:
            self._answer(message)
        assert "error" not in message, (method, message)
        assert "exceptionDetails" not in message["result"], (method, message)
        return message["result"]

    def _next(self) -> dict[str, Any]:
        data = b""
        while not data.endswith(b"\0"):
            piece = self._in.read(1)
            assert piece, "the browser has ended"
            data += piece
        return dict(json.loads(data[:-1]))

    def _answer(self, message: dict[str, Any]) -> None:
        about = message.get("params", {})
        if message.get("method") == "Fetch.requestPaused":
            self._send("Fetch.continueRequest", requestId=about["requestId"])
        elif message.get("method") == "Fetch.authRequired":
            assert about["authChallenge"]["scheme"] == "digest"
            answer = {"response": "ProvideCredentials", **self._credentials}
            self._send("Fetch.continueWithAuth", requestId=about["requestId"],
                       authChallengeResponse=answer)  # fmt: skip

    def close(self) -> None:
        """Hear no more of it."""
        self._out.close()
        self._in.close()


@contextmanager
def opened(folder: str, user: str, password: str) -> Iterator[Browser]:
    """Run a browser whose files are in `folder`, and end it."""
    assert NAME is not None
    theirs, told = os.pipe()
    tells, own = os.pipe()
    high = [fcntl.fcntl(each, fcntl.F_DUPFD_CLOEXEC, 50) for each in (theirs, own)]
    os.close(theirs)
    os.close(own)
    starter = [sys.executable, "-c", _AS_3_AND_4, *map(str, high), NAME]
    log = open(f"{folder}/browser.log", "wb")  # noqa: SIM115 (closed below)
    process = subprocess.Popen([*starter, *_OPTIONS, f"--user-data-dir={folder}/browser"],
                               pass_fds=high, stdin=subprocess.DEVNULL, stdout=log,
                               stderr=log, start_new_session=True)  # fmt: skip
    for each in high:
        os.close(each)
    browser = None
    try:
        browser = Browser(told, tells, user, password)
        yield browser
    finally:
        if browser is not None:
            browser.close()
        os.killpg(process.pid, 9)
        process.wait(30)
        log.close()
