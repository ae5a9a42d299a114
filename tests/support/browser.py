"""Drives a real headless browser over its debugging pipe."""

from __future__ import annotations

import fcntl
import json
import os
import shutil
import subprocess
import sys
from base64 import b64decode
from collections.abc import Iterator, Sequence
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


_CODES = {
    "Tab": 9, "Enter": 13, " ": 32, "ArrowLeft": 37, "ArrowUp": 38, "ArrowRight": 39,
    "ArrowDown": 40, "Escape": 27,
}  # fmt: skip
_WATCHED = """
window.troubles = [];
document.addEventListener("securitypolicyviolation", (event) =>
    window.troubles.push(`${event.violatedDirective} ${event.blockedURI}`));
for (const kind of ["error", "unhandledrejection"])
    window.addEventListener(kind, (event) =>
        window.troubles.push(`${kind} ${event.message || event.reason}`));
"""


class Browser:
    """One page. `user` and `password` are given to whoever asks for them, in one scheme: Digest.

    Attributes:
        is_known: They are given; if not, the question is cancelled, as by who does not know them.
        asked: How often somebody has asked for them.
    """

    def __init__(self, told: int, tells: int, user: str, password: str) -> None:
        self._out = os.fdopen(told, "wb", buffering=0)
        self._in = os.fdopen(tells, "rb")
        self._credentials = {"username": user, "password": password}
        self.is_known = True
        self.asked = 0
        self._id = 0
        self._saved, self._known = set[str](), set[str]()
        self._session = ""
        target = self._do("Target.createTarget", url="about:blank")["targetId"]
        attached = self._do("Target.attachToTarget", targetId=target, flatten=True)
        self._session = attached["sessionId"]
        self._do("Fetch.enable", handleAuthRequests=True)
        self._do("Page.enable")
        self._do("Page.addScriptToEvaluateOnNewDocument", source=_WATCHED)

    def trust_all(self) -> None:
        """Open pages whatever certificate they show, as one who accepts it."""
        self._do("Security.setIgnoreCertificateErrors", ignore=True)

    def go(self, url: str) -> None:
        """Open a page."""
        self._do("Page.navigate", url=url)

    def reload(self) -> None:
        """Load the page anew, and wait until it is there: the old one answers until then."""
        self._do("Page.reload")
        while (message := self._next()).get("method") != "Page.loadEventFired":
            self._answer(message)

    def wait_for(self, condition: str) -> None:
        """Wait until an expression of the page is true: what fields hold, no observer is told."""
        self._do(
            "Runtime.evaluate",
            awaitPromise=True,
            expression=f"""new Promise((done, fail) => {{
            const looked = setInterval(() => {{
                if ({condition}) {{ clearInterval(looked); done(true); }} }}, 15);
            setTimeout(() => fail(new Error("not so: " + {json.dumps(condition)}
                + " in " + document.body.innerText)), 20000);
        }})""",
        )

    def evaluate(self, expression: str) -> Any:
        """Return what an expression of the page is."""
        return self._do("Runtime.evaluate", expression=expression)["result"].get("value")

    def awaited(self, expression: str) -> Any:
        """Return what a promise of the page comes to."""
        done = self._do("Runtime.evaluate", expression=expression, awaitPromise=True)
        return done["result"].get("value")

    def troubles(self) -> list[str]:
        """Return what the policy of the page has stopped, and the errors that nobody has caught."""
        found: list[str] = json.loads(self.evaluate("JSON.stringify(window.troubles)"))
        return found

    def place(self, selector: str) -> tuple[float, float, float, float]:
        """Return where an element rests, scrolled to: left, top, width, height."""
        return self._place(selector, "found.scrollIntoView({block: 'center'});")

    def middle(self, selector: str) -> tuple[float, float]:
        """Return the middle of an element of a diagram, which is moved and not scrolled."""
        left, top, width, height = self._place(selector)
        return left + width / 2, top + height / 2

    def _place(self, selector: str, before: str = "") -> tuple[float, float, float, float]:
        """Return where an element rests; each time it is looked for, something is done before.

        What comes late above an element moves it, and a diagram is moved to what is selected: it
        rests when some frames find it in one place.
        """
        look = f"""(async () => {{
            let place = "", frames = 0;
            while (frames < 5) {{
                await new Promise(requestAnimationFrame);
                const found = document.querySelector({json.dumps(selector)});
                {before}
                const box = found.getBoundingClientRect();
                const now = JSON.stringify([box.left, box.top, box.width, box.height]);
                frames = now === place ? frames + 1 : 0;
                place = now;
            }}
            return place;
        }})()"""
        left, top, width, height = json.loads(self.awaited(look))
        return left, top, width, height

    def mouse(self, kind: str, x: float, y: float, *, is_control: bool = False) -> None:
        """Move, press or release the mouse: mouseMoved, mousePressed, mouseReleased."""
        given = {"button": "left", "buttons": 0 if kind == "mouseReleased" else 1, "clickCount": 1}
        given["modifiers"] = 2 if is_control else 0
        self._do("Input.dispatchMouseEvent", type=kind, x=x, y=y, **given)

    def hover(self, x: float, y: float) -> None:
        """Move the mouse to a place with no button pressed."""
        self._do("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y, buttons=0)

    def wheel(self, x: float, y: float, delta: float) -> None:
        """Turn the wheel at a place: down by a positive `delta` [px]."""
        self._do("Input.dispatchMouseEvent", type="mouseWheel", x=x, y=y, deltaX=0, deltaY=delta)

    def touch(self, x: float, y: float) -> None:
        """Touch a place with a finger, and let go."""
        self.finger("touchStart", x, y)
        self.finger("touchEnd")

    def finger(self, kind: str, *place: float) -> None:
        """Put down or move a finger to a place, or lift it: touchStart, touchMove, touchEnd."""
        points = [dict(zip("xy", place, strict=True))] if place else []
        self._do("Input.dispatchTouchEvent", type=kind, touchPoints=points)

    def click(self, selector: str) -> None:
        """Click the middle of an element."""
        left, top, width, height = self.place(selector)
        for kind in ("mousePressed", "mouseReleased"):
            self.mouse(kind, left + width / 2, top + height / 2)

    def key(
        self,
        name: str,
        kinds: Sequence[str] = ("keyDown", "keyUp"),
        *,
        is_control: bool = False,
        is_shift: bool = False,
    ) -> None:
        """Press and release a key, as the page calls it: ArrowRight, Tab, Enter, a …"""
        code = _CODES.get(name, ord(name[0].upper()) if name.isalnum() else 0)
        text = {"Enter": "\r"}.get(name, name if len(name) == 1 else "")
        for kind in kinds:
            more: dict[str, Any] = {"modifiers": 2 * is_control + 8 * is_shift}
            more |= {"text": text} if text and kind == "keyDown" and not is_control else {}
            self._do("Input.dispatchKeyEvent", type=kind, key=name, windowsVirtualKeyCode=code,
                     **more)  # fmt: skip

    def type(self, selector: str, text: str) -> None:
        """Put a text in place of what a field holds, as one who pastes it."""
        field = f"document.querySelector({json.dumps(selector)})"
        self.evaluate(f"{field}.focus(); {field}.select()")
        self._do("Input.insertText", text=text)

    def press(self, text: str) -> None:
        """Click the button that has this text."""
        buttons = "[...document.querySelectorAll('button:not([disabled])')]"
        found = f"{buttons}.find((each) => each.textContent.trim() === {json.dumps(text)})"
        self.wait_for(f"{found} !== undefined")
        self.evaluate(f"{found}.click()")

    def save_to(self, folder: str) -> None:
        """Have downloads saved in a folder."""
        self._do("Browser.setDownloadBehavior", behavior="allow", downloadPath=folder,
                 eventsEnabled=True)  # fmt: skip

    def saved(self) -> None:
        """Wait until the download that was begun last is whole."""
        while self._saved <= self._known:
            self._answer(self._next())
        self._known |= self._saved

    def look(self, *, is_dark: bool) -> None:
        """Have the page light or dark."""
        features = [{"name": "prefers-color-scheme", "value": "dark" if is_dark else "light"}]
        self._do("Emulation.setEmulatedMedia", features=features)

    def rest(self) -> None:
        """Wait until nothing on the page is on its way to another place or colour."""
        self.wait_for("document.getAnimations().every((each) => each.playState !== 'running')")

    def violations(self, axe: str) -> list[str]:
        """Return what axe-core, of which this is the source, finds against the page as it is."""
        self.rest()
        self.evaluate(axe)
        run = """axe.run({resultTypes: ["violations"]}).then(({violations}) => JSON.stringify(
            violations.flatMap(({id, nodes}) => nodes.map((node) => `${id}: ${node.html}`))))"""
        return list(json.loads(self.awaited(run)))

    def picture(self, path: str, width: int, height: int, *, is_dark: bool = False) -> None:
        """Save a picture of the page as it looks in a window of that size."""
        self._do("Emulation.setDeviceMetricsOverride", width=width, height=height,
                 deviceScaleFactor=1, mobile=False)  # fmt: skip
        self.look(is_dark=is_dark)
        data = self._do("Page.captureScreenshot", format="png")["data"]
        with open(path, "wb") as stream:
            stream.write(b64decode(data))

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
        elif message.get("method", "").endswith(".downloadProgress"):
            if about["state"] == "completed":
                self._saved.add(about["guid"])
        elif message.get("method") == "Fetch.authRequired":
            assert about["authChallenge"]["scheme"] == "digest"
            self.asked += 1
            given = {"response": "ProvideCredentials", **self._credentials}
            answer = given if self.is_known else {"response": "CancelAuth"}
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
