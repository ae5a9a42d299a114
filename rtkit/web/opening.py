"""Opens the page in the browser of the user.

The command line of a browser can be read by every user of the host, and an address with the secret
would stand there. So the browser is given a file that only this user can read, and that leads on.
"""

from __future__ import annotations

import html
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Thread

from rtkit.link.atomic import write_output
from rtkit.link.places import make_private, runtime_path


@contextmanager
def signpost() -> Iterator[Callable[[str], bool]]:
    """Return what opens an address, and returns whether there is a browser; the file goes at last.

    Raises:
        Refused: The folder of this user's sockets is open to others.
    """
    path = os.path.join(make_private(runtime_path()), f"web.{os.getpid()}.html")

    def lead(address: str) -> bool:
        import webbrowser

        try:
            browser = webbrowser.get()
        except webbrowser.Error:
            return False
        text = f'<!doctype html><meta http-equiv="refresh" content="0; url={html.escape(address)}">'
        write_output(text.encode(), path, mode=0o600)
        # A browser in a terminal returns when it is left.
        Thread(target=browser.open, args=(f"file://{path}",), daemon=True).start()
        return True

    try:
        yield lead
    finally:
        if os.path.exists(path):
            os.unlink(path)
