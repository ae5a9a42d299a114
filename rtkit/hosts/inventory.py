"""Inventory of hosts: ``hosts.toml``, a table for each host.

As the hosts that it names are trusted with code, no stranger may be able to write it.
"""

from __future__ import annotations

import fcntl
import os
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from rtkit.errors import Malformed, NotFound, Refused
from rtkit.fast_dataclass import replace
from rtkit.hosts.host import Host, host_at, is_word, named
from rtkit.link import places
from rtkit.rtc.names import check_host_name
from rtkit.rtc.nearest import did_you_mean
from rtkit.settings.inventory_files import files, hint, user_file
from rtkit.settings.reading import read_private

_TEXTS = ("address", "python", "manager", "index")
_KEYS = (*_TEXTS, "tags", "extras")


def read() -> dict[str, Host]:
    """Return all known hosts by name.

    Raises:
        Malformed: Names file, host and key.
        Refused: A stranger can have written a file.
    """
    found: dict[str, Host] = {}
    for file in reversed(files()):
        found.update(_read(file))
    return dict(sorted(found.items()))


def host(name: str) -> Host:
    """Return a known host.

    Raises:
        NotFound: There is none of that name; tells what may have been meant.
    """
    known = read()
    if name not in known:
        raise NotFound(f"no such host: {name}{hint(name, known)}")
    return known[name]


def add(new: Host, *, is_forced: bool = False) -> None:
    """Add a host to the user's inventory; what else stands there stays as it is.

    Raises:
        Refused: There is one of that name already, or the name is that of this host.
        Malformed: One of its tags is no word, rtkit has no such extra, or its index is none.
    """
    _check_tags(new.tags)
    _check_index(new.index)
    if new.extras:
        check_extras(new.extras)
    if new.name == places.host_name():
        raise Refused(f"{new.name} is the name of this host in the tree")
    with _edited() as document:
        _put(document, new, is_forced=is_forced)


def check_extras(extras: Iterable[str]) -> None:
    """Check that rtkit has these extras.

    Raises:
        Malformed: Tells which there are.
    """
    import importlib.metadata

    known = importlib.metadata.metadata("rtkit").get_all("Provides-Extra") or []
    for each in extras:
        if each not in known:
            raise Malformed(f"rtkit has no extra {each}; there are {', '.join(sorted(known))}")


def _check_tags(tags: Iterable[str]) -> None:
    for each in tags:
        if not (each and is_word(each)):
            raise Malformed(f"a tag is one word: {each!r}")


def _check_index(index: str) -> None:
    """Check the address of an index, which others there see (ps): it has no secret in it."""
    if not index:
        return
    from urllib.parse import urlsplit

    try:
        parts = urlsplit(index)
        at = parts.hostname if parts.scheme in ("http", "https") and parts.port != 0 else ""
    except ValueError:
        at = ""
    if not (at and is_word(index)):
        raise Malformed(f"an index is http[s]://ADDRESS[:PORT]/...: {index!r}")
    if parts.username is not None:
        raise Malformed(f"a secret in the address of an index: that at {at} is to need none")


def _put(document: Any, new: Host, *, is_forced: bool) -> None:
    if new.name in document and not is_forced:
        raise Refused(f"host {new.name} is there already; --force replaces it")
    table: dict[str, Any] = {"address": str(new)}
    usual = Host("", "")
    for key in _KEYS[1:]:
        if (value := getattr(new, key)) != getattr(usual, key):
            table[key] = value if isinstance(value, str) else [*value]
    document[new.name] = table


def remove(name: str) -> None:
    """Remove a host from the user's inventory.

    Raises:
        NotFound: It is not in it.
    """
    with _edited() as document:
        if name not in document:
            elsewhere = [each for each in files() if each != user_file() and name in _read(each)]
            where = f"; it stands in {elsewhere[0]}" if elsewhere else ""
            raise NotFound(f"no such host in {user_file()}: {name}{where}")
        del document[name]


def _read(file: str) -> dict[str, Host]:
    return _parsed(file, read_private(file, must_be_ours=True))


def _document() -> Any:
    import tomlkit
    from tomlkit.exceptions import TOMLKitError

    path = user_file()
    if not os.path.lexists(path):
        return tomlkit.document()
    data = read_private(path, must_be_ours=True)
    _parsed(path, data)
    try:
        return tomlkit.parse(data)
    except TOMLKitError as error:
        raise Malformed(f"{path}: {error}") from error


@contextmanager
def _edited() -> Iterator[Any]:
    """Give the user's inventory to be changed, to one at a time; write it if nothing fails."""
    import tomlkit

    from rtkit.link.atomic import write_output

    path = user_file()
    places.make_folders(os.path.dirname(path))
    folder = os.open(os.path.dirname(path), os.O_RDONLY | os.O_CLOEXEC)
    try:
        fcntl.flock(folder, fcntl.LOCK_EX)
        document = _document()
        yield document
        write_output(tomlkit.dumps(document).encode(), path, mode=0o600)
    finally:
        os.close(folder)


def _parsed(path: str, data: bytes) -> dict[str, Host]:
    try:
        tables = tomllib.loads(data.decode("utf-8"))
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise Malformed(f"{path}: {error}") from None
    try:
        return {name: _host(name, table) for name, table in tables.items()}
    except Malformed as error:
        raise Malformed(f"{path}: {error}") from None


def _host(name: str, table: Any) -> Host:
    check_host_name(name)
    if not isinstance(table, Mapping):
        raise Malformed(f"{name}: not a table, as [{name}]")
    for key in table:
        if key not in _KEYS:
            raise Malformed(f"{name}: unknown key: {key}{did_you_mean(key, _KEYS)}")
    texts: dict[str, Any] = {
        "address": "",
        **{each: table[each] for each in _TEXTS if each in table},
    }
    for key, value in texts.items():
        if not (isinstance(value, str) and value):
            raise Malformed(f"{name}: {key}: not a text")
    tags, extras = table.get("tags", []), table.get("extras", [])
    for key, words in (("tags", tags), ("extras", extras)):
        if not isinstance(words, list) or not all(isinstance(each, str) for each in words):
            raise Malformed(f"{name}: {key}: not a list of texts")
    with named(name):
        _check_tags(tags)
        _check_index(texts.get("index", ""))
        if extras:
            check_extras(extras)
    with named(f"{name}: address"):
        at = host_at(name, str(texts.pop("address")))
    return replace(at, tags=tuple(tags), extras=tuple(sorted(set(extras))), **texts)
