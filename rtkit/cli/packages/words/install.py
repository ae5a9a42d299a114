"""``rtpkg install``: install packages for the managers of the user."""

from __future__ import annotations

import os
import threading
from collections.abc import Sequence
from typing import TYPE_CHECKING

from rtkit.cli.packages.far import HOST, at_hosts
from rtkit.cli.packages.records import installed_record, show
from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, flag, json_flag, option, several
from rtkit.errors import UsageProblem

if TYPE_CHECKING:
    from packaging.requirements import Requirement

    from rtkit.hosts.connection import HostConnection
    from rtkit.hosts.far_packager import PackageAnswer
    from rtkit.hosts.progress import Progress
    from rtkit.packages.repository import Repositories
    from rtkit.packages.wheel_target import WheelTarget


@command(
    "install",
    is_local=True,
    examples=(
        ("rtpkg install rtc-scale==1.0.0 --repository wheels", "This version, beside others."),
        ("rtpkg install --lock robot.lock", "What the lock says, with these very bytes."),
        ("rtpkg install robot.rtbundle", "All packages of a bundle, from nowhere else."),
        ("rtpkg install --host robot1 rtc-scale", "Pushed to a host, which may be offline."),
    ),
    json=("package",),
    arguments=("anything",),
)
def main(
    app: App,
    repositories: tuple[str, ...] = several("--repository PLACE", "Where to look; repeatable."),
    lock: str = option(
        "--lock FILE", "Refuse wheels whose bytes differ; add those it lacks.", default=""
    ),
    must_be_signed: bool = flag(
        "--signed", "Refuse what no operator has signed (rtpkg sign); also its needs."
    ),
    hosts: tuple[str, ...] = several("--host NAME", HOST),
    is_json: bool = json_flag(),
    names: tuple[str, ...] = arguments("[NAME[==VERSION]|BUNDLE]..."),
) -> int:
    """Install packages with all that they need, each version in a folder of its own.

    NAME may have constraints, 'NAME>=1.2,<2'. The packages that it needs come from the
    repositories, too, but for those that the Python of rtkit has. BUNDLE is a file that rtpkg
    bundle made; it is all that is needed then. Nothing of a package is run. Managers find its types
    at once: by name the newest version, by RTC:vendor:category:type:language:version the one with
    that id.

    With --host packages are looked for here and pushed over SSH to a host that rtmgr start --host
    has brought up, with all that they need: it asks no repository, and needs no network. Wheels are
    chosen for its Python and machine; one that no repository has is told before anything is sent.
    """
    from rtkit.packages.bundle import is_bundle
    from rtkit.packages.installed import install, install_bundle, read_lock, write_lock
    from rtkit.packages.repository import named_repositories, opened
    from rtkit.packages.resolving import requirement

    locked = read_lock(lock) if lock else {}
    if hosts and (lock or must_be_signed):
        raise UsageProblem("--host goes with neither --lock nor --signed (signed = true does)")
    if not names and not locked:
        raise WrongArguments("takes names of packages, or the lock that has them")
    digests = {file: digest for wheels in locked.values() for file, digest in wheels.items()}
    bundles = [each for each in names if is_bundle(each)]
    plain = [each for each in names or locked if each not in bundles]
    if hosts:
        return _push(app, hosts, repositories, (plain, bundles), is_json)
    done = [
        package
        for each in bundles
        for package in install_bundle(each, digests, must_be_signed=must_be_signed)
    ]
    asked = [requirement(each) for each in plain]
    with opened(named_repositories(repositories) if plain else ()) as there:
        for wanted in asked:
            done.append(install(wanted, there, digests, must_be_signed=must_be_signed))
    if lock:
        write_lock(lock, locked | {each.text: each.wheels for each in done})
    records = [installed_record(each) for each in done]
    if is_json or app.is_verbose:
        show(records, is_json)
    return 0


def _push(
    app: App,
    hosts: Sequence[str],
    repositories: Sequence[str],
    wanted: tuple[Sequence[str], Sequence[str]],
    is_json: bool,
) -> int:
    import tempfile

    from rtkit.hosts.far_packages import push, push_bundle
    from rtkit.hosts.progress import HostStep
    from rtkit.packages.repository import named_repositories, opened
    from rtkit.packages.resolving import requirement

    plain, bundles = wanted
    asked = [requirement(each) for each in dict.fromkeys(plain)]
    with (
        opened(named_repositories(repositories) if plain else ()) as there,
        tempfile.TemporaryDirectory(prefix="rtpkg-") as draft,
    ):
        fetching = _Fetching(asked, there, draft)

        def work(connection: HostConnection, show: Progress) -> list[PackageAnswer]:
            show(connection.host.name, HostStep("choosing wheels"))
            packages = fetching.for_host(connection) if asked else {}
            done = [push_bundle(connection, path, show) for path in bundles]
            return done + ([push(connection, packages, show=show)] if packages else [])

        return at_hosts(app, hosts, work, is_json or None, _summary)


def _summary(done: PackageAnswer) -> str:
    """Tell which packages are new on a host, and which were there."""
    new = [each.text for each in done.packages if each.text in done.made]
    there = [each.text for each in done.packages if each.text not in done.made]
    parts = [f"{', '.join(new)} installed"] if new else []
    return "; ".join(parts + ([f"{', '.join(there)} there already"] if there else []))


class _Fetching:
    """Fetches packages for hosts, once for each kind of host; for one host after the other."""

    def __init__(self, asked: list[Requirement], there: Repositories, draft: str) -> None:
        self._asked = asked
        self._there = there
        self._draft = draft
        self._known: list[tuple[WheelTarget, dict[str, list[str]]]] = []
        self._turn = threading.Lock()

    def for_host(self, connection: HostConnection) -> dict[str, list[str]]:
        """Return the wheels of all packages, with what a host lacks for them."""
        from rtkit.errors import Refused
        from rtkit.hosts.far_side import look
        from rtkit.hosts.host import named

        host, found = connection.host.name, look(connection)
        if not found.current:
            raise Refused(f"{host}: no rtkit is there yet: rtmgr start --host {host} brings it")
        with self._turn, named(host):
            return self._for_target(found.target)

    def _for_target(self, wanted: WheelTarget) -> dict[str, list[str]]:
        from rtkit.packages.bundling import fetched

        for target, packages in self._known:
            if target == wanted:
                return packages
        folder = os.path.join(self._draft, str(len(self._known)))
        os.mkdir(folder)
        packages = {}
        for each in self._asked:
            packages |= fetched(each, self._there, folder, wanted)
        self._known.append((wanted, packages))
        return packages
