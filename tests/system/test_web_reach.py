"""Where the page is reached: here, elsewhere by TLS, or elsewhere without, told and shown."""

from __future__ import annotations

import re
import ssl
from collections.abc import Iterator
from contextlib import contextmanager
from http.client import HTTPConnection, HTTPSConnection
from pathlib import Path

import pytest
from shells import Shell
from webkit import certified

_BOUND_S = 20.0


@contextmanager
def listening(shell: Shell, options: str) -> Iterator[tuple[str, str, int, str]]:
    """Run ``rtweb``; yield scheme, host, port and secret of the address that it prints."""
    process = shell.open(f"rtweb --no-browser {options}")
    assert process.stdout is not None
    found = re.fullmatch(r"(https?)://([^/]+):(\d+)/#token=(\S+)\n", process.stdout.readline())
    assert found is not None
    try:
        yield found[1], found[2], int(found[3]), found[4]
    finally:
        process.send_signal(2)
        shell.end_of(process)


def status(connection: HTTPConnection, token: str, **headers: str) -> int:
    connection.request("GET", "/api/events", headers={"Authorization": f"Bearer {token}"} | headers)
    found = connection.getresponse().status
    connection.close()
    return found


@pytest.mark.parametrize("address", ["0.0.0.0", "10.0.0.7", "::"])
def test_other_hosts_are_not_let_in_without_tls_unless_told(
    shared_shell: Shell, address: str
) -> None:
    failed = shared_shell.run(f"rtweb --no-browser --bind {address}")
    assert failed.status == 1
    assert f"on this host only, not {address}" in failed.err
    assert "--cert FILE --key FILE, or --insecure" in failed.err


def test_what_is_insecure_is_told_and_shown_and_asked_by_its_own_names(shell: Shell) -> None:
    with listening(shell, "--bind 0.0.0.0 --insecure") as (scheme, host, port, token):
        assert scheme == "http"
        assert f"http://{host}:{port}/" in shell.run("rtls -l").err
        for name in (host, "localhost", "127.0.0.2"):
            connection = HTTPConnection("127.0.0.2", port, timeout=_BOUND_S)
            assert status(connection, token, Host=f"{name}:{port}") == 200
        for name in ("evil.example.org", "10.0.0.7", "127.0.0.1"):  # which it did not come to
            connection = HTTPConnection("127.0.0.2", port, timeout=_BOUND_S)
            assert status(connection, token, Host=f"{name}:{port}") == 403
    assert "insecure" not in shell.run("rtls -l").err


@pytest.fixture
def pair(tmp_path: Path) -> tuple[Path, Path]:
    """A certificate for this host's names, and its key."""
    return certified(tmp_path)


def test_by_tls_others_are_let_in(shell: Shell, pair: tuple[Path, Path]) -> None:
    cert, key = pair
    with listening(shell, f"--bind 0.0.0.0 --cert {cert} --key {key}") as (scheme, _, port, token):
        assert scheme == "https"
        context = ssl.create_default_context(cafile=str(cert))
        secure = HTTPSConnection("localhost", port, timeout=_BOUND_S, context=context)
        assert status(secure, token) == 200
        secure = HTTPSConnection("localhost", port, timeout=_BOUND_S, context=context)
        assert status(secure, token, Origin=f"http://localhost:{port}") == 403
        context.maximum_version = ssl.TLSVersion.TLSv1_2
        old = HTTPSConnection("localhost", port, timeout=_BOUND_S, context=context)
        with pytest.raises(ssl.SSLError):
            old.request("GET", "/")
        with pytest.raises(OSError):  # noqa: PT011 (reset or closed, as the kernel likes)
            status(HTTPConnection("localhost", port, timeout=_BOUND_S), token)
        assert "insecure" not in shell.run("rtls -l").err


def test_a_bad_certificate_is_told(shell: Shell, pair: tuple[Path, Path]) -> None:
    cert, key = pair
    assert "go together" in shell.run(f"rtweb --cert {cert}").err
    assert "no certificate and its key" in shell.run(f"rtweb --cert {key} --key {key}").err
    assert "nowhere" in shell.run(f"rtweb --cert nowhere --key {key}").err
    key.chmod(0o644)
    assert "others can read it (mode 644)" in shell.run(f"rtweb --cert {cert} --key {key}").err
