"""Logs a user in at an sshd by keys: of the agent, of files, with a passphrase on a terminal."""

from __future__ import annotations

import getpass
import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from rtkit.errors import Refused
from rtkit.hosts.ssh_config import SshRoute
from rtkit.hosts.ssh_library import paramiko
from rtkit.link import unix

_USUAL = ("id_ed25519", "id_ecdsa", "id_rsa")
_asking = threading.Lock()
_asker: Callable[[str], str] | None = None
_unlocked: dict[str, paramiko.PKey | str] = {}
"""Keys whose passphrase was asked for, or why there is none: asked once, for all hosts."""


def ask(prompt: str) -> str:
    """Ask the user on the terminal for something that is not shown."""
    return getpass.getpass(prompt)


@contextmanager
def asked_by(asker: Callable[[str], str]) -> Iterator[None]:
    """Have the user be asked by `asker` while inside."""
    global _asker
    former, _asker = _asker, asker
    try:
        yield
    finally:
        _asker = former


def log_in(transport: paramiko.Transport, way: SshRoute, where: str) -> None:
    """Log in; the key of the host has been verified before.

    Raises:
        Refused: Nobody of this user is let in; tells what was tried, and what to do.
    """
    keys = _Keys(way)
    tried = []
    try:
        for name, key in keys:
            tried.append(name)
            with suppress(paramiko.AuthenticationException):
                _offer(transport, way, key, where)
                return
            if not transport.is_active():
                raise Refused(
                    f"{where}: user {way.user} is not let in: the sshd has had enough after"
                    f" {len(tried)} keys (IdentitiesOnly and IdentityFile choose the right one)"
                )
        _check_methods(transport, way, where)
    finally:
        keys.close()
    raise Refused(f"{where}: user {way.user} is not let in: {_why(way, tried, keys.notes)}")


def _offer(transport: paramiko.Transport, way: SshRoute, key: paramiko.PKey, where: str) -> None:
    try:
        further = transport.auth_publickey(way.user, key)
    except paramiko.BadAuthenticationType as error:
        raise _no_keys(way, where, error.allowed_types) from error
    except paramiko.AuthenticationException as error:
        if "timeout" in str(error).lower():
            raise TimeoutError(str(error)) from error
        raise
    if further:
        raise Refused(f"{where}: besides the key the sshd there asks for {', '.join(further)}")


def _check_methods(transport: paramiko.Transport, way: SshRoute, where: str) -> None:
    """Ask how one may log in, if there was no key to try.

    Raises:
        Refused: Not by keys.
    """
    try:
        transport.auth_none(way.user)
    except paramiko.BadAuthenticationType as error:
        if "publickey" not in error.allowed_types:
            raise _no_keys(way, where, error.allowed_types) from error
    except paramiko.AuthenticationException:
        pass


def _no_keys(way: SshRoute, where: str, allowed: list[str]) -> Refused:
    return Refused(
        f"{where}: user {way.user} is not let in: the sshd there takes no keys, but only"
        f" {', '.join(allowed)}; rtkit sends no passwords: allow PubkeyAuthentication there, then"
        f" ssh-copy-id -p {way.port} {way.user}@{way.address}"
    )


def _why(way: SshRoute, tried: list[str], notes: list[str]) -> str:
    text = f"it takes none of the keys {', '.join(tried)}" if tried else "there is no key to try"
    copy = f"ssh-copy-id -p {way.port} {way.user}@{way.address}"
    if notes:
        return "; ".join([text, *notes])
    return f"{text}; have one be known there: {'' if tried else 'ssh-keygen; '}{copy}"


class _Keys(paramiko.agent.AgentSSH):
    """Keys to try, in order, each with a name: what costs the user nothing comes first."""

    def __init__(self, way: SshRoute) -> None:
        super().__init__()
        self._way = way
        self.notes: list[str] = []
        self._files = way.identities
        if not way.identities:
            usual = (os.path.expanduser(f"~/.ssh/{name}") for name in _USUAL)
            self._files = tuple(each for each in usual if os.path.exists(each))
        if way.agent:
            try:
                self._connect(unix.connect(way.agent, 5.0))  # type: ignore[attr-defined]
            except (OSError, paramiko.SSHException) as error:
                self.notes.append(f"the agent at {way.agent} does not answer ({error})")

    def close(self) -> None:
        """End the connection to the agent."""
        self._close()  # type: ignore[attr-defined]

    def __iter__(self) -> Iterator[tuple[str, paramiko.PKey]]:
        public = {data: file for file in self._files if (data := _public(file))}
        others: list[tuple[str, paramiko.PKey]] = []
        held = set()
        for key in self.get_keys():
            data = key.asbytes()
            if data in public:
                held.add(public[data])
                yield f"{public[data]} (agent)", key
            elif self._way.uses_all_keys:
                others.append((f"{key.comment or key.get_name()} (agent)", key))
        files = [self._load(file) for file in self._files if file not in held]
        plain = [(file, key) for file, key in files if isinstance(key, paramiko.PKey)]
        yield from [*plain, *others] if self._way.identities else [*others, *plain]
        for file, found in files:
            if found == "locked" and (opened := self._ask(file)) is not None:
                yield file, opened

    def _load(self, file: str) -> tuple[str, paramiko.PKey | str]:
        """Return a file with its key, "locked" if it needs a passphrase, else "" (noted)."""
        try:
            return file, self._certified(file, paramiko.PKey.from_path(file))
        except TypeError:
            return file, "locked"
        except FileNotFoundError:
            self.notes.append(f"no such key file: {file}")
        except (OSError, ValueError, paramiko.SSHException, paramiko.pkey.UnknownKeyType) as error:
            self.notes.append(f"no key that can be read: {file} ({error})")
        return file, ""

    def _certified(self, file: str, key: paramiko.PKey) -> paramiko.PKey:
        for each in self._way.certificates:
            try:
                key.load_certificate(each)
                break
            except ValueError:  # it is of another key
                continue
            except OSError as error:
                self.notes.append(f"no certificate for {file}: {each}: {error.strerror}")
        return key

    def _ask(self, file: str) -> paramiko.PKey | None:
        """Ask for a passphrase, once, on a terminal only; neither shown nor kept."""
        with _asking:
            if file not in _unlocked:
                _unlocked[file] = self._unlock(file)
            found = _unlocked[file]
        if isinstance(found, paramiko.PKey):
            return found
        self.notes.append(found)
        return None

    def _unlock(self, file: str) -> paramiko.PKey | str:
        if not (sys.stdin and sys.stdin.isatty() and sys.stderr.isatty()):
            return f"{file} has a passphrase and no agent holds it: ssh-add {file}"
        try:
            text = (_asker or ask)(f"Passphrase of {file}: ")
            return self._certified(file, paramiko.PKey.from_path(file, text.encode()))  # type: ignore[arg-type]
        except (EOFError, ValueError, paramiko.SSHException):
            return f"that is not the passphrase of {file}"


def _public(file: str) -> bytes:
    """Return the public half of a key file from the file beside it; empty if there is none."""
    import base64

    try:
        with open(f"{file.removesuffix('.pub')}.pub", encoding="utf-8") as stream:
            return base64.b64decode(stream.read().split()[1])
    except (OSError, ValueError, IndexError):
        return b""
