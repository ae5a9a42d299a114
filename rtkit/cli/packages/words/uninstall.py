"""``rtpkg uninstall``: remove installed packages."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtkit.cli.packages.far import HOST, at_hosts
from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, flag, several

if TYPE_CHECKING:
    from rtkit.hosts.connection import HostConnection
    from rtkit.hosts.far_packager import PackageAnswer
    from rtkit.hosts.progress import Progress


@command(
    "uninstall",
    is_local=True,
    examples=(
        ("rtpkg uninstall rtc-scale==1.0.0", "This version; others stay."),
        ("rtpkg uninstall rtc-scale --force", "All versions, though a manager uses one."),
    ),
    arguments=("installed-package",),
)
def main(
    app: App,
    is_forced: bool = flag("--force", "Also what a running manager uses."),
    hosts: tuple[str, ...] = several("--host NAME", HOST),
    names: tuple[str, ...] = arguments("NAME[==VERSION]..."),
) -> int:
    """Uninstall packages, unless a running manager has loaded a module of one.

    All installed versions that fit; what was installed with a package goes with it.
    """
    from rtkit.packages.installed import meant, remove
    from rtkit.packages.resolving import requirement
    from rtkit.packages.usage import check_unused

    if not names:
        raise WrongArguments("takes names of packages")
    if hosts:
        from rtkit.hosts import far_packages

        def work(connection: HostConnection, _show: Progress) -> list[PackageAnswer]:
            return [far_packages.remove(connection, names, is_forced=is_forced)]

        def summary(done: PackageAnswer) -> str:
            return f"{', '.join(each.text for each in done.packages)} removed"

        return at_hosts(app, hosts, work, None, summary)
    found = [each for name in names for each in meant(requirement(name))]
    for each in () if is_forced else found:
        check_unused(each, app.timeout_s)
    for each in found:
        remove(each)
        app.verbose(f"{each.text} is removed")
    return 0
