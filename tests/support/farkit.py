"""Other hosts for tests: namespaces with a real sshd, a network link, own files and processes.

Nothing is prepared on such a host but sshd, Python, and the key of the test's user.
"""

from __future__ import annotations

import itertools
import os
import shutil
import signal
import socket
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

from lossykit import LossyLink
from waiting import until

_numbers = itertools.count()
_SSHD = "/usr/sbin/sshd"
_OPTIONS = "-o UsePAM=no -o PasswordAuthentication=no -o StrictModes=no -o PrintMotd=no"


@cache
def missing() -> str:
    """Return why there can be no such host here, empty if there can."""
    if os.getuid():
        return "only root may have network namespaces"
    tools = {"ip": "iproute2", "unshare": "util-linux", _SSHD: "openssh-server"}
    lacking = [package for tool, package in tools.items() if not shutil.which(tool)]
    if lacking:
        return f"not installed: {', '.join(lacking)}"
    done = subprocess.run(["unshare", "-n", "true"], capture_output=True, text=True, check=False)
    return f"no network namespace can be had here: {done.stderr}" if done.returncode else ""


class FarHost:
    """A host in namespaces.

    Attributes:
        name: Its host name.
        address: Where its sshd listens.
        folder: Of the test: keys, and what sshd says.
        wire: Its network link, if that is to lose packets.
    """

    def __init__(
        self, name: str, folder: Path, room: str = "600m", *, is_lossy: bool = False
    ) -> None:
        number = next(_numbers)
        low = 4 * (number % 63) + 1
        net = f"10.{200 + os.getpid() // 250 % 50}.{os.getpid() % 250}"
        self.name, self.folder = name, folder
        self.near, self.address = f"{net}.{low}", f"{net}.{low + 1}"
        self._space = f"rtk{os.getpid()}n{number}"
        self._ends = (f"rtk{number}p{os.getpid()}"[:15], f"rtf{number}p{os.getpid()}"[:15])
        self._log = (folder / f"{name}.sshd").open("wb")
        self._sshd: subprocess.Popen[bytes] | None = None
        self._room = room
        self._is_lossy = is_lossy
        self.wire: LossyLink | None = None

    @property
    def key(self) -> Path:
        """The private key of the test's user."""
        return self.folder / "key"

    def open(self) -> None:
        """Have the host, and wait until its sshd listens."""
        for name in ("key", "hostkey"):
            if not (self.folder / name).exists():
                _run("ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", str(self.folder / name))
        near, far = self._ends
        _run("ip", "netns", "add", self._space)
        if self._is_lossy:
            self.wire = LossyLink(self._ends)
        else:
            _run("ip", "link", "add", near, "type", "veth", "peer", "name", far)
        _run("ip", "link", "set", far, "netns", self._space)
        _run("ip", "addr", "add", f"{self.near}/30", "dev", near)
        _run("ip", "link", "set", near, "up")
        for words in (
            ["addr", "add", f"{self.address}/30", "dev", far],
            ["link", "set", far, "up"],
            ["link", "set", "lo", "up"],
        ):
            _run("ip", "-n", self._space, *words)
        self.power_on()

    def power_on(self) -> None:
        """Start it: its home is empty but for the key of the user."""
        keys = f"/dev/shm/{self._space}"
        script = f"""
            set -e
            hostname {self.name}
            mount --make-rprivate /
            mkdir -p {keys}; cp {self.folder}/key.pub {self.folder}/hostkey {keys}/
            mount -t tmpfs -o size={self._room},mode=700 tmpfs /root
            mkdir -m 700 /root/.ssh; cp {keys}/key.pub /root/.ssh/authorized_keys
            mv {keys}/hostkey /root/.ssh/hostkey; chmod 600 /root/.ssh/*; rm -r {keys}
            mount -t tmpfs -o mode=1777 tmpfs /tmp; mount -t tmpfs tmpfs /run; mkdir /run/sshd
            mount -t tmpfs -o mode=1777 tmpfs /dev/shm
            exec {_SSHD} -D -e -p 22 -h /root/.ssh/hostkey {_OPTIONS}
        """
        spaces = ["unshare", "-m", "-u", "-i", "-p", "--fork", "--mount-proc", "--kill-child"]
        command = ["ip", "netns", "exec", self._space, *spaces, "sh", "-c", script]
        self._sshd = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=self._log, stderr=self._log
        )
        until(self._is_listening, f"sshd of {self.name}")

    def _is_listening(self) -> bool:
        assert self._sshd is not None
        assert self._sshd.poll() is None, (self.folder / f"{self.name}.sshd").read_text()
        with socket.socket() as probe:
            probe.settimeout(1.0)
            return probe.connect_ex((self.address, 22)) == 0

    def power_off(self) -> None:
        """End all of its processes at once."""
        if self._sshd is not None:
            self._sshd.send_signal(signal.SIGKILL)
            self._sshd.wait()
            self._sshd = None

    def link(self, state: str) -> None:
        """Cut its network link (``down``) or heal it (``up``)."""
        _run("ip", "-n", self._space, "link", "set", self._ends[1], state)

    def run(self, *words: str) -> str:
        """Run a command there as its root user would at its console; return what it writes."""
        own = ["HOME=/root", f"PATH={os.environ['PATH']}"]  # nothing of this host's user
        inside = ["nsenter", "-t", self._inside(), "-a", "env", "-i", *own]
        done = subprocess.run([*inside, *words], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    def read(self, path: str) -> str:
        """Return the text of a file there."""
        return (self._root / path.lstrip("/")).read_text()

    def write(self, path: str, text: str) -> None:
        """Write a file there."""
        (self._root / path.lstrip("/")).write_text(text)

    def folder_of(self, path: str) -> Path:
        """Return a folder there, for who copies much."""
        return self._root / path.lstrip("/")

    @property
    def _root(self) -> Path:
        """Its root folder, as its first process sees it."""
        return Path(f"/proc/{self._inside()}/root")

    def _inside(self) -> str:
        """Return its first process."""
        assert self._sshd is not None
        pids = subprocess.run(
            ["pgrep", "-P", str(self._sshd.pid)], capture_output=True, text=True, check=True
        )
        return pids.stdout.split()[0]

    def sshd(self, port: int, *options: str, key: str = "/root/.ssh/hostkey") -> None:
        """Have one more sshd there at a port of its own, with options of its own."""
        words = [word for option in options for word in ("-o", option)]
        self.run(_SSHD, "-p", str(port), "-h", key, *words, *_OPTIONS.split())

    def close(self) -> None:
        """Have it no longer."""
        self.power_off()
        if self.wire is not None:
            self.wire.close()
        with suppress(subprocess.CalledProcessError):
            _run("ip", "link", "del", self._ends[0])
        with suppress(subprocess.CalledProcessError):
            _run("ip", "netns", "del", self._space)
        self._log.close()


@contextmanager
def far_hosts(folder: Path, *names: str, is_lossy: bool = False) -> Iterator[list[FarHost]]:
    """Have hosts of these names; with a `wire` each that may lose packets."""
    hosts = [FarHost(name, folder, is_lossy=is_lossy) for name in names]
    try:
        for host in hosts:
            host.open()
        yield hosts
    finally:
        for host in hosts:
            host.close()


def _run(*words: str) -> None:
    subprocess.run(words, check=True, capture_output=True)
