"""Program that fetches wheels on a host, from a simple index (PEP 503) that the host reaches.

It is sent as text to the interpreter there. Its argument is JSON: ``index``, ``wheels`` by name
with their SHA-256 and size, the ``folder`` for them, and ``mark`` that begins its answer: why it
has not fetched some, by name. Only the right bytes are kept. An index that does
not answer, or too slowly, is asked for no more. Lines before the answer tell what is fetched.
"""

import hashlib
import html
import http.client
import json
import os
import re
import signal
import sys
import time
import urllib.error
import urllib.parse
import urllib.request

_SILENT_S = 10.0
_BEGIN_S = 20
_SLOWEST = 100_000
"""How much of a wheel is to come on average, but for `_BEGIN_S` [bytes/s]."""
_PAGE = 1 << 25
_PIECE = 1 << 16


def _read(url: str, most: int, step: str) -> tuple[str, bytes]:
    """Return what is at an address, and where it was at last."""
    if not url.startswith(("http://", "https://")):
        raise ValueError("its link leads elsewhere")
    data, shown_at = bytearray(), 0.0
    request = urllib.request.Request(url, headers={"Accept": "text/html, */*;q=0.1"})
    with urllib.request.urlopen(request, timeout=_SILENT_S) as answer:
        while piece := answer.read1(_PIECE):
            data += piece
            if len(data) > most:
                raise ValueError("it has too many bytes")
            if time.monotonic() > shown_at + 1.0:
                shown_at = time.monotonic()
                print(step, flush=True)
        return answer.url, bytes(data)


def _address(index: str, name: str, step: str) -> str:
    """Return where the page of a package says that a wheel is."""
    project = re.sub("[-_.]+", "-", name.split("-")[0]).lower()
    page, text = _read(f"{index.rstrip('/')}/{project}/", _PAGE, step)
    for link in re.findall(rb"href\s*=\s*[\"']([^\"']+)", text, re.IGNORECASE):
        path = html.unescape(link.decode("utf-8", "replace")).partition("#")[0]
        if urllib.parse.unquote(path.partition("?")[0].rpartition("/")[2]) == name:
            return urllib.parse.urljoin(page, path)
    raise ValueError("it is not there")


def _fetch(index: str, name: str, digest: str, size: int, folder: str, step: str) -> None:
    """Fetch a wheel, in bounded time, also from an index that sends byte by byte."""
    signal.alarm(_BEGIN_S + size // _SLOWEST)
    _, data = _read(_address(index, name, step), size, step)
    if hashlib.sha256(data).hexdigest() != digest:
        raise ValueError("it has other bytes (SHA-256)")
    with open(os.path.join(folder, name), "wb") as file:
        file.write(data)


def _stop(*_: object) -> None:
    raise TimeoutError("it sends too slowly")


def main() -> None:
    """Be the program."""
    wanted = json.loads(sys.argv[1])
    failed, away = {}, ""
    signal.signal(signal.SIGALRM, _stop)
    for number, (name, (digest, size)) in enumerate(sorted(wanted["wheels"].items())):
        step = f"fetching {number} {len(wanted['wheels'])} {name.split('-')[0]}"
        try:
            if not away:
                _fetch(wanted["index"], name, digest, size, wanted["folder"], step)
        except urllib.error.HTTPError as error:
            failed[name] = f"the index answers {error.code} {error.reason}"
        except (OSError, http.client.HTTPException) as error:
            away = f"no answer of the index: {getattr(error, 'reason', '') or error}"
        except ValueError as error:
            failed[name] = str(error)
        if away:
            failed[name] = away
    signal.alarm(0)
    print(wanted["mark"] + json.dumps(failed), flush=True)


if __name__ == "__main__":
    main()
