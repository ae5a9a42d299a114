"""Layout and escaping of zenoh keys; no other module knows the layout.

==================================================  =============================================
``rt/<realm>/<host>/<manager>[/<instance>]/@/P``    property P of a manager or component
``rt/<realm>/<host>/<manager>[/<instance>]/@x/…``   reserved extensions (snapshot, meta, gui)
``rt/<realm>/<host>/<manager>/@x/line/LINE``        what a manager tells all who listen
``rt/<realm>/<host>/@ps/<service>/…``                a property service of no manager, likewise
``rt/<realm>/<host>/@ps/@p/<host>/<service>/…``      the same, as services of another host ask it
``…/@e/<listener>``                                 events of a service to one listener
``rt/<realm>/<host>/@ps/…/<service>/@``             presence of a property service
``rt/<realm>/<host>/<manager>/@p/<host>/<manager>`` what a manager is asked by one of another host
``rtd/<realm>/<host>/<connector id>``               data of one connector
``rtd/<realm>/<host>/<other host>/<connector id>``  between hosts, first the one that is waited at
``rtw/<realm>``                                     who the manager at an address is
==================================================  =============================================

Chunks that begin with ``@`` are matched by no wildcard, so the two spaces never mix.
"""

from __future__ import annotations

import os

_EXTENSIONS = frozenset({"properties", "parameters", "gui", "listen", "meta", "history"})
_MARKS = ("@", "@x", "@e")
_UNSAFE = "*$?#/%@"


def escape(chunk: str) -> str:
    """Return a name as one key chunk."""
    if chunk and not any(c in _UNSAFE or ord(c) < 33 for c in chunk):
        return chunk
    return "".join(f"%{ord(c):02X}" if c in _UNSAFE or ord(c) < 33 else c for c in chunk) or "%"


def unescape(chunk: str) -> str:
    """Return the name that `escape` turned into this chunk; other characters stay as they are."""
    head, *rest = chunk.split("%")
    return head + "".join(_unescaped(part) for part in rest)


def _unescaped(part: str) -> str:
    code = part[:2]
    if len(code) == 2 and all(c in "0123456789ABCDEFabcdef" for c in code):
        return chr(int(code, 16)) + part[2:]
    return f"%{part}" if part else ""


def realm() -> str:
    """Return the realm: systems of different realms never meet (``RTKIT_REALM``)."""
    return escape(os.environ.get("RTKIT_REALM") or "default")


def service(host: str, manager: str, instance: str = "") -> str:
    """Return the key of a manager, or of a component below it."""
    base = f"rt/{realm()}/{escape(host)}/{escape(manager)}"
    return f"{base}/{escape(instance)}" if instance else base


def property_service(host: str, service: str) -> str:
    """Return the key of a property service that belongs to no manager."""
    return f"rt/{realm()}/{escape(host)}/@ps/{service}"


def service_for(host: str, service: str, asking: str) -> str:
    """Return the key of a property service, as services of another host ask it."""
    return f"rt/{realm()}/{escape(host)}/@ps/@p/{escape(asking)}/{service}"


def presence(service_key: str) -> str:
    """Return the key of the token by which a property service is known to be there."""
    return f"{service_key}/@"


def of_target(service_key: str, name: str) -> str:
    """Return the key of a property by its name in canonical spelling, which has extensions last.

    A key holds the extension first, behind a mark that wildcards do not match.
    """
    segments = name.split(".")
    for back in (1, 2):
        if len(segments) >= back and segments[-back] in _EXTENSIONS:
            head = ".".join(segments[-back:])
            return "/".join([service_key, "@x", head, *segments[:-back]])
    return "/".join([service_key, "@", *segments])


def to_target(name: str, *, is_extension: bool) -> str:
    """Return the name of a property from the part of a key behind the mark."""
    head, _, rest = name.partition("/")
    if not is_extension:
        return name.replace("/", ".")
    return f"{rest.replace('/', '.')}.{head}" if rest else head


def introduction(of_realm: str = "") -> str:
    """Return the key of a manager's identity, for clients that know only its address.

    `of_realm` is this one by default, ``*`` for any.
    """
    return f"rtw/{of_realm or realm()}"


def all_of_host(host: str) -> list[str]:
    """Return the expressions for all keys of a host, ``*`` for any: marks match no wildcard."""
    own = f"rt/{realm()}/{host if host == '*' else escape(host)}"
    return [f"{own}/{place}/{mark}/**" for place in ("*", "*/*", "@ps/**") for mark in _MARKS]


def questions_by(host: str) -> list[str]:
    """Return the expressions for what a host may ask managers and services of others."""
    own = host if host == "*" else escape(host)
    services = [f"rt/{realm()}/*/@ps/@p/{own}/**/{mark}/**" for mark in _MARKS]
    return [f"rt/{realm()}/*/*/@p/{own}/*", *services]


def questions_to(host: str) -> list[str]:
    """Return the expressions for what other hosts ask managers and services of a host."""
    own = f"rt/{realm()}/{escape(host)}"
    return [f"{own}/*/@p/**", *(f"{own}/@ps/@p/**/{mark}/**" for mark in _MARKS)]


def data_between(host: str) -> list[str]:
    """Return the expressions for all data from and to a host, ``*`` for any."""
    own = host if host == "*" else escape(host)
    return [f"rtd/{realm()}/{own}/*/**", f"rtd/{realm()}/*/{own}/**"]


def property_key(service_key: str, name: str) -> str:
    """Return the key of a property of a service; chunks of its name are separated by ``/``."""
    return f"{service_key}/@/{'/'.join(map(escape, name.split('/')))}"


def extension_key(service_key: str, name: str) -> str:
    """Return the key of a reserved extension of a service."""
    return f"{service_key}/@x/{name}"


def line_key(service_key: str, line: str) -> str:
    """Return the key of a topic on which a manager sends texts to all subscribers."""
    return f"{service_key}/@x/line/{line}"


def question(peer: str, asking: str) -> str:
    """Return the key at which a manager is asked by one of another host, both ``HOST/NAME``."""
    to, by = ("/".join(map(escape, each.split("/", 1))) for each in (peer, asking))
    return f"rt/{realm()}/{to}/@p/{by}"


def far_data(listening: str, reaching: str, connector_id: str) -> str:
    """Return the key on which a connector's data travel from host to host."""
    return f"rtd/{realm()}/{escape(listening)}/{escape(reaching)}/{escape(connector_id)}"


def data(host: str, connector_id: str) -> str:
    """Return the key on which one connector's data travel."""
    return f"rtd/{realm()}/{escape(host)}/{escape(connector_id)}"
