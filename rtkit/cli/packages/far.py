"""Does the words of ``rtpkg`` on other hosts, at the same time; what came of it is told of each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from rtkit.cli.hosts.at_all import at_all, status
from rtkit.cli.packages.records import record, show
from rtkit.cli.shared.app import App
from rtkit.errors import RtkitError

if TYPE_CHECKING:
    from rtkit.hosts.connection import HostConnection
    from rtkit.hosts.far_packager import PackageAnswer, Signed
    from rtkit.hosts.host import Host
    from rtkit.hosts.progress import Progress
    from rtkit.packages.records import Installed

    Work = Callable[[HostConnection, Progress], Sequence[PackageAnswer]]

HOST = "On a host of rthost list; repeatable."


def at_hosts(
    app: App,
    names: Sequence[str],
    work: Work,
    is_json: bool | None,
    summary: Callable[[PackageAnswer], str] = str,
) -> int:
    """Do some work at hosts, and tell what came of it; return the exit status.

    Args:
        app: The run.
        names: Of the hosts.
        work: Is done at each of them.
        is_json: How the packages that it is about are shown; None for not at all.
        summary: Tells what came of it, where that is not shown.
    """
    from rtkit.hosts import inventory, ssh_config
    from rtkit.hosts.connection import connect
    from rtkit.hosts.progress import HostStep

    hosts = [inventory.host(name) for name in dict.fromkeys(names)]
    app.warn(ssh_config.remarks(hosts))

    def one(host: Host, show_step: Progress) -> Sequence[PackageAnswer]:
        show_step(host.name, HostStep("connecting"))
        with connect(host, app.timeout_s) as connection:
            return work(connection, show_step)

    def line(answers: Sequence[PackageAnswer]) -> str:
        return "; ".join(map(summary, answers)) if is_json is None else ""

    found = at_all(app, hosts, one, line)
    if is_json is not None:
        done = ((n, each) for n, each in found.items() if not isinstance(each, RtkitError))
        answers = [(name, answer) for name, all in done for answer in all]
        show([_record(n, each, a) for n, a in answers for each in a.packages], is_json)
    return status(app, found)


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
