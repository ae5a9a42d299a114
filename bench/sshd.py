"""Runs a real OpenSSH server on loopback, with keys that are thrown away; and its client."""

from __future__ import annotations

import contextlib
import os
import pwd
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from rtkit.link.tcp_endpoint import free_port

_PATIENCE_S = 10.0
_PRIVILEGES = "/run/sshd"
_PROMPT = b"rtbench> "


class NoServer(Exception):
    """There is none on this machine, or it does not start; says why."""


class Login:
    """How to log in at the server: the `line` of the client, which the command follows."""

    def __init__(self, line: list[str]) -> None:
        self.line = line

    def script(self, text: str) -> None:
        """Log in once and have a shell do a script."""
        subprocess.run(
            [*self.line, "-T", "sh -es"],
            input=text.encode(),
            stdout=subprocess.DEVNULL,
            check=True,
        )

    def type(self, lines: list[str]) -> None:
        """Log in on a terminal and type lines, each when the prompt of the one before is there."""
        ours, theirs = os.openpty()
        with contextlib.ExitStack() as stack:
            stack.callback(os.close, ours)
            shell = subprocess.Popen(
                [*self.line, "-tt"], stdin=theirs, stdout=theirs, stderr=theirs
            )
            os.close(theirs)
            stack.callback(shell.wait)
            # Written in two pieces, so that the echo of what is typed is not taken for it.
            for line in (f"PS1={_PROMPT[:4].decode()!r}{_PROMPT[4:].decode()!r}", *lines):
                os.write(ours, f"{line}\n".encode())
                _await(ours, _PROMPT)
            os.write(ours, b"exit\n")
            with contextlib.suppress(OSError):  # the other end of the terminal is closed
                while os.read(ours, 4096):
                    pass


def _await(terminal: int, text: bytes) -> None:
    seen = b""
    while text not in seen:
        seen += os.read(terminal, 4096)


@contextmanager
def server(folder: str) -> Iterator[Login]:
    """Run a server that lets this user in, with the environment of this process.

    Raises:
        NoServer: There is none, or it does not start.
    """
    program = shutil.which("sshd") or shutil.which("sshd", path="/usr/sbin:/usr/local/sbin")
    missing = [n for n in ("ssh", "ssh-keygen") if shutil.which(n) is None]
    if program is None or missing:
        raise NoServer(f"no {'sshd' if program is None else missing[0]} on this machine")
    port = free_port()
    with _privileges():
        process = _start(program, folder, port)
        try:
            yield Login(_client(folder, port))
        finally:
            process.terminate()
            process.wait()


@contextmanager
def _privileges() -> Iterator[None]:
    """Have the folder that a server of root wants, which is there only where one has run."""
    if os.getuid() or os.path.isdir(_PRIVILEGES):
        yield
        return
    os.makedirs(_PRIVILEGES, 0o755)
    try:
        yield
    finally:
        os.rmdir(_PRIVILEGES)


def _start(program: str, folder: str, port: int) -> subprocess.Popen[Any]:
    for name in ("host", "user"):
        _key(os.path.join(folder, name))
    config = os.path.join(folder, "sshd_config")
    with open(config, "w", encoding="utf-8") as file:
        file.write(_configuration(folder, port))
    log = os.path.join(folder, "sshd.log")
    process = subprocess.Popen([program, "-D", "-f", config, "-E", log])
    deadline = time.monotonic() + _PATIENCE_S
    while not _listens(port):
        if process.poll() is not None or time.monotonic() > deadline:
            process.kill()
            process.wait()
            with open(log, encoding="utf-8", errors="replace") as file:
                raise NoServer(f"sshd does not start: {' '.join(file.read().split())}")
        time.sleep(0.01)
    return process


def _key(path: str) -> None:
    subprocess.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", path], check=True)


def _configuration(folder: str, port: int) -> str:
    names = ("RTKIT_RUNTIME_DIR", "RTKIT_STATE_DIR", "RTKIT_MODULE_PATH", "PYTHONPATH")
    given = {name: os.environ[name] for name in names if os.environ.get(name)}
    environment = " ".join(f'"{name}={value}"' for name, value in given.items())
    return f"""ListenAddress 127.0.0.1
Port {port}
HostKey {folder}/host
AuthorizedKeysFile {folder}/user.pub
PidFile none
StrictModes no
UsePAM no
PasswordAuthentication no
KbdInteractiveAuthentication no
PermitRootLogin prohibit-password
PrintMotd no
PrintLastLog no
SetEnv {environment}
"""


def _client(folder: str, port: int) -> list[str]:
    known = os.path.join(folder, "known_hosts")
    with open(os.path.join(folder, "host.pub"), encoding="utf-8") as file:
        kind, key = file.read().split()[:2]
    with open(known, "w", encoding="utf-8") as file:
        file.write(f"[127.0.0.1]:{port} {kind} {key}\n")
    options = ("BatchMode=yes", "IdentitiesOnly=yes", f"UserKnownHostsFile={known}")
    line = ["ssh", "-F", "none", "-p", str(port), "-i", os.path.join(folder, "user"), "-q"]
    for option in options:
        line += ["-o", option]
    return [*line, f"{pwd.getpwuid(os.getuid()).pw_name}@127.0.0.1"]


def _listens(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0
