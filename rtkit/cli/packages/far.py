"""Does the words of ``rtpkg`` on other hosts, one after the other; each that fails is told."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from rtkit.cli.packages.records import record, show
from rtkit.cli.shared.app import App
from rtkit.errors import RtkitError

if TYPE_CHECKING:
    from rtkit.hosts.connection import HostConnection
    from rtkit.hosts.far_packager import PackageAnswer, Signed
    from rtkit.packages.installed import Installed

HOST = "On a host of rthost list; repeatable."


def at_hosts(
    app: App,
    names: Sequence[str],
    work: Callable[[HostConnection], Sequence[PackageAnswer]],
    is_json: bool | None,
) -> int:
    """Do some work at hosts, and show the packages that it is about; return the exit status.

    Args:
        app: The run.
        names: Of the hosts.
        work: Is done at each of them.
        is_json: How it is shown; None for not at all.
    """
    from rtkit.hosts import inventory
    from rtkit.hosts.connection import connect

    hosts = [inventory.host(name) for name in dict.fromkeys(names)]
    records: list[dict[str, Any]] = []
    failures: list[RtkitError] = []
    for host in hosts:
        try:
            with connect(host, app.timeout_s) as connection:
                for answer in work(connection):
                    records += [_record(host.name, each, answer) for each in answer.packages]
        except RtkitError as error:
            failures.append(error)
            app.fail(str(error))
    if is_json is not None:
        show(records, is_json)
    return app.status(failures[0]) if failures else 0


def _record(host: str, found: Installed, answer: PackageAnswer) -> dict[str, Any]:
    return record(
        found.name,
        found.version,
        f"{host}:{found.path}",
        types=found.types,
        requires=found.requires,
        wheels={**found.wheels},
        signed_by=_signer(answer.signed.get(found.text, ())),
    )


def _signer(wheels: Sequence[Signed]) -> str | None:
    """Return who has signed a package and all that it needs, None where nobody known here has."""
    from rtkit.packages.signing import WHEEL, signer

    try:
        names = [
            signer(each.signature.encode(), bytes.fromhex(each.sha256), WHEEL) for each in wheels
        ]
    except (RtkitError, ValueError):
        return None
    return names[0] if names else None
