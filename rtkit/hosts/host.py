"""Host: a name in the tree, and the way to it, over SSH or over TLS."""

from __future__ import annotations

import ipaddress
from collections.abc import Iterator
from contextlib import contextmanager

from rtkit.errors import Malformed, Refused, RtkitError
from rtkit.fast_dataclass import Record, replace
from rtkit.rtc.manager_address import is_port
from rtkit.rtc.names import check_host_name

MANAGER = "manager"
_TLS = "tls:"


class Host(Record):
    """A host of the inventory.

    Attributes:
        name: Its name in the tree, ``/robot1``; also the one by which its manager knows itself.
        address: Where its sshd listens: a name, an IP address, or a ``Host`` of OpenSSH's file.
        user: Who logs in; empty for what OpenSSH's file says, else the present user.
        port: Of its sshd; 0 for what OpenSSH's file says, else 22.
        python: The interpreter that makes virtual environments there.
        manager: The manager there that is linked.
        tags: Words by which requirements of components choose it.
        extras: What its rtkit is made with besides: ``sim`` brings numpy.
        is_tls: It is reached over TLS, at the port of its manager for certificates.
        index: Simple index that it reaches, from which it fetches wheels; empty for none.
    """

    name: str
    address: str
    user: str = ""
    port: int = 0
    python: str = "python3"
    manager: str = MANAGER
    tags: tuple[str, ...] = ()
    extras: tuple[str, ...] = ()
    is_tls: bool = False
    index: str = ""

    def __str__(self) -> str:
        user = f"{self.user}@" if self.user else ""
        address = f"[{self.address}]" if ":" in self.address else self.address
        at = f"{user}{address}{f':{self.port}' if self.port else ''}"
        return f"{_TLS}{at}" if self.is_tls else at

    @property
    def tls_address(self) -> str:
        """Address of the port for certificates, as commands take it; only if it `is_tls`."""
        return str(self).removeprefix(_TLS)

    def check_manager(self, far: str, manager: str) -> None:
        """Compare the manager that answers at the address with the one that is meant.

        Raises:
            Refused: It is another one, or of another host.
        """
        if (far, manager) != (self.name, self.manager):
            raise Refused(
                f"{self.name}: at {self} is manager {manager} of host {far}, not {self.manager} of"
                f" {self.name} (rthost add {far} {self} --manager {manager})"
            )

    def check_shell(self) -> None:
        """Refuse a host where no command can be run.

        Raises:
            Refused: It is reached over TLS.
        """
        if self.is_tls:
            raise Refused(
                f"{self.name} is reached over TLS ({self}): nothing is made or run there but by its"
                " manager (rthost add NAME USER@ADDRESS goes over SSH)"
            )


@contextmanager
def named(host: str) -> Iterator[None]:
    """Have errors inside name a host that they are about.

    Raises:
        RtkitError: As inside.
    """
    try:
        yield
    except RtkitError as error:
        raise type(error)(f"{host}: {error}") from error


def host_at(name: str, typed: str) -> Host:
    """Return the host ``[USER@]ADDRESS[:PORT]`` or ``tls:ADDRESS:PORT``; IPv6 stands in brackets.

    Raises:
        Malformed: It cannot be read; or the name is none, or one that stands for this host.
    """
    check_host_name(name)
    if typed.startswith(_TLS):
        found = host_at(name, typed.removeprefix(_TLS))
        if found.user or not found.port:
            raise Malformed(f"not tls:ADDRESS:PORT: {typed!r}")
        return replace(found, is_tls=True)
    user, at, place = typed.rpartition("@")
    address, colon, port = place.rpartition(":")
    if not colon or place.endswith("]") or (":" in address and not address.endswith("]")):
        address, port = place, ""
    if colon and port and not is_port(port):
        raise Malformed(f"not a port: {port} (in {typed})")
    bare = address.removeprefix("[").removesuffix("]")
    if not bare or (at and not user) or not is_word(bare) or (user and not is_word(user)):
        raise Malformed(f"not [USER@]ADDRESS[:PORT]: {typed!r}")
    if ":" in bare:
        _check_ipv6(bare, typed)
    return Host(name, bare, user, int(port or 0))


def _check_ipv6(address: str, typed: str) -> None:
    try:
        ipaddress.IPv6Address(address)
    except ValueError as error:
        raise Malformed(f"not an IPv6 address: {address} (in {typed}): {error}") from None


def is_word(text: str) -> bool:
    """Return whether a text is one word, and no option."""
    return text.isprintable() and not any(c.isspace() for c in text) and not text.startswith("-")
