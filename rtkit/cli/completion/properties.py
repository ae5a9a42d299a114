"""Completes live properties of services, components, managers and this host."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from rtkit.cli.completion.candidates import Candidate
from rtkit.cli.completion.live import CompletionSource, WantedPath, living, paths
from rtkit.cli.shared.app import working_directory
from rtkit.errors import RtkitError
from rtkit.rtc.names import LOCAL
from rtkit.tree.live_place import split
from rtkit.tree.view import NodeKind, TreeNode

_MOST_ASKED = 8
_PATIENCE_S = 0.3
_MORE = ("history", "meta", "parameters", "properties")
"""Suffixes that ask about any property, behind its name."""
_STATES = ("Active", "Inactive")


def targets(typed: str, live: CompletionSource) -> list[Candidate]:
    """Return the ways to go on with a target: services, paths, or the next step of a name."""
    path, name = split(typed, working_directory())
    if path and typed.count(".") > path.rpartition("/")[2].count("."):
        front = typed[: len(typed) - len(name)]
        return _steps(front, _names_of(path, live.timeout_s), name)
    found = [*_of_services(typed), *_of_host(typed)]
    try:
        found += [_going_on(each) for each in paths(live, typed, WantedPath(_has_properties))]
    except RtkitError:
        return found  # services are there without a manager, too
    return found


def values(target: str, typed: str, timeout_s: float) -> list[Candidate]:
    """Return known candidates for the value of a property: its present one, and others.

    Of an action they are forms to fill in, one for each choice of its first argument.
    """
    from rtkit.tree.property_connections import PropertyConnections

    places = PropertyConnections(working_directory(), "", timeout_s)
    try:
        place, end = places.find(target)
        present = _plain(str(end.ask(place.target()).value()))
        choices = _choices(str(end.ask(f"{place.name}.meta").value()))
    except RtkitError:
        return []
    finally:
        places.close()
    words = choices or (_STATES if present in _STATES else (present,))
    return [
        Candidate(word, "as it is" if word == present else "")
        for word in words
        if word.startswith(typed) and word.isprintable()
    ]


def _choices(described: str) -> list[str]:
    """Return what the meta data of a property allow; of an action, with its other arguments."""
    from rtkit.property.reading import read
    from rtkit.property.values import Element

    meta = read(described)
    assert isinstance(meta, Element)
    allowed, arguments = (meta.find(name) for name in ("choices", "arguments"))
    if allowed is not None and isinstance(allowed.leaf, tuple):
        return list(map(str, allowed.leaf))
    if arguments is None or not isinstance(arguments.leaf, tuple):
        return []
    rows: list[Any] = list(arguments.leaf)
    rest = "".join(f" {name}" for name, *_ in rows[1:])
    return [f"({each}{rest})" if rest else str(each) for each in rows[0][3]]


def _plain(text: str) -> str:
    """Return a value as it can be typed: a word without its quotes."""
    word = text[1:-1]
    return word if text == f'"{word}"' and word.isidentifier() else text


def _has_properties(node: TreeNode) -> bool:
    return living(node) or (node.kind is NodeKind.MANAGER and not node.is_slave)


def _going_on(candidate: Candidate) -> Candidate:
    is_folder = candidate.text.endswith("/")
    return candidate if is_folder else candidate._replace(text=f"{candidate.text}.")


def _names_of(path: str, timeout_s: float) -> list[str]:
    from rtkit.tree.live_place import open_live

    try:
        owner = open_live(path, timeout_s)
    except RtkitError:
        return []
    try:
        return _listed(str(owner.ask("properties?all").value()))
    except RtkitError:
        return []
    finally:
        owner.close()


def _of_services(typed: str) -> Iterator[Candidate]:
    """Yield services, and steps of the properties of those of which the name is typed."""
    from rtkit.link.places import service_socket, services
    from rtkit.wires.line.client import connect_unix

    front = f"/{LOCAL}/" if typed.startswith(f"/{LOCAL}/") else ""
    rest = typed[len(front) :]
    names = [name for name in services() if f"{name}.".startswith(rest[: len(name) + 1])]
    for name in names[:_MOST_ASKED]:
        try:
            with connect_unix(service_socket(name), _PATIENCE_S) as client:
                if len(rest) <= len(name):
                    yield Candidate(f"{front}{name}.", "service")
                    continue
                listed = _listed(str(client.ask("properties?all").value()))
        except RtkitError:
            continue  # the socket is stale: the next service may answer
        yield from _steps(f"{front}{name}.", listed, rest[len(name) + 1 :])


def _of_host(typed: str) -> Iterable[Candidate]:
    front = f"{LOCAL}."
    if not typed.startswith(front):
        return ()
    from rtkit.tree.live_properties import ThisHost

    return _steps(front, ThisHost(list, list).names, typed[len(front) :])


def _listed(text: str) -> list[str]:
    return text.strip("()").split()


def _steps(front: str, names: Iterable[str], typed: str) -> list[Candidate]:
    """Return names that begin as typed, up to the next dot; what can be asked of one of them."""
    known = set(names)
    inner = {name.rpartition(".")[0] for name in known}
    steps: dict[str, None] = {}
    for name in names:
        if name.startswith(typed):
            step, dot, _ = name[len(typed) :].partition(".")
            whole = f"{typed}{step}"
            steps[f"{front}{whole}{'.' * bool(dot or whole in inner)}"] = None
    whose, _, more = typed.rpartition(".")
    if whose in known and more:
        steps |= {f"{front}{whose}.{each}": None for each in _MORE if each.startswith(more)}
    return [Candidate(step) for step in steps]
