"""Checks the keys of this user, and the files that say whom to trust."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from datetime import UTC, datetime
from typing import TYPE_CHECKING

from rtkit.cli.managers.doctor import ERROR, OK, WARNING, Diagnosis
from rtkit.errors import Malformed, Refused, RtkitError
from rtkit.keys import audit, folder
from rtkit.link import places

if TYPE_CHECKING:
    from rtkit.keys.authority import Issued

_SOON_DAYS = 30
_SHUT = 0o077


def own_keys() -> Iterator[Diagnosis]:
    """Look at the folder of keys, at what lies in it, and at the record of what others did."""
    path = folder.path()
    if not os.path.lexists(path):
        yield Diagnosis("keys", OK, "no keys: nobody on another host is let in", "", path)
    else:
        found = [*_open_to_others(path), *_unusable(path)]
        yield from found or _times(path)
    if os.path.lexists(audit.file()):
        yield from _open_to_others(audit.file())


def hosts() -> Iterator[Diagnosis]:
    """Look at the inventories of hosts, which say whom this user gives code to."""
    from rtkit.hosts import inventory

    try:
        known = inventory.read()
    except (Refused, Malformed) as error:
        yield Diagnosis(
            "hosts", ERROR, str(error), "chmod go-w that file, and look at what it says"
        )
    else:
        yield Diagnosis("hosts", OK, f"inventory: {len(known)} hosts")


def _open_to_others(path: str) -> Iterator[Diagnosis]:
    """Yield what others may read or write that is for this user alone."""
    mode = os.stat(path).st_mode
    others = 0o022 if stat.S_ISDIR(mode) else _SHUT
    if mode & others:
        what = "write in" if others == 0o022 else "read"
        text = f"others can {what} {path} (mode {mode & 0o777:o})"
        yield Diagnosis("keys", ERROR, text, f"chmod go= {places.quoted(path)}", path)


def _unusable(path: str) -> Iterator[Diagnosis]:
    """Yield each file that cannot be used, or that they do not fit together."""
    names = [folder.CA_CERTIFICATE, folder.CERTIFICATE, folder.KEY, folder.REVOKED]
    if os.path.lexists(folder.file(folder.CA_KEY)):
        names.append(folder.CA_KEY)
    whole = True
    for name in names:
        try:
            os.close(folder.opened(name))
        except RtkitError as error:
            whole = False
            text, _, cure = str(error).rpartition(" (")
            yield Diagnosis("keys", ERROR, text, cure.removesuffix(")"), folder.file(name))
    if whole:
        from rtkit.keys.tls import Trust

        try:
            Trust(is_server=True)
        except RtkitError as error:
            cure = "rtkit keys issue makes others, where the CA is"
            yield Diagnosis("keys", ERROR, str(error), cure, path)


def _times(path: str) -> Iterator[Diagnosis]:
    from rtkit.keys import authority

    try:
        yield judge(authority.own(), datetime.now(UTC))
    except (RtkitError, ValueError) as error:
        yield Diagnosis("keys", ERROR, f"certificate cannot be read: {error}", "", path)


def judge(own: Issued, now: datetime) -> Diagnosis:
    """Return what is to be said of the certificate of this user."""
    who, cure = f"the certificate of {own.name}", f"rtkit keys issue {own.name}, where the CA is"
    if own.revoked is not None:
        return Diagnosis("keys", ERROR, f"{who} is revoked", cure, own.name)
    if not own.begins <= now <= own.ends:
        text = f"{who} is good from {own.begins:%Y-%m-%d} until {own.ends:%Y-%m-%d} only"
        return Diagnosis("keys", ERROR, text, f"{cure}; or set the clock", own.name)
    days = (own.ends - now).days
    if days < _SOON_DAYS:
        return Diagnosis("keys", WARNING, f"{who} ends in {days} days", cure, own.name)
    return Diagnosis("keys", OK, f"{who} ({own.role}) ends in {days} days", "", own.name)
