"""``rtpkg list``: which packages are installed?"""

from __future__ import annotations

from rtkit.cli.packages.far import HOST, at_hosts
from rtkit.cli.packages.records import installed_record, show
from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, json_flag, several


@command(
    "list",
    is_local=True,
    examples=(
        ("rtpkg list", "Name, version, types, folder."),
        ("rtpkg list --json", "Also wheels with their SHA-256, and what they need."),
    ),
    json=("package",),
    arguments=(),
)
def main(
    app: App,
    hosts: tuple[str, ...] = several("--host NAME", HOST),
    is_json: bool = json_flag(),
    words: tuple[str, ...] = arguments(""),
) -> int:
    """List the installed packages, the newest version of each first."""
    from rtkit.packages.installed import installed

    if words:
        raise WrongArguments(f"takes no arguments: {words[0]}")
    if hosts:
        from rtkit.hosts.far_packages import listed

        return at_hosts(app, hosts, lambda connection, _: [listed(connection)], is_json)
    found = [installed_record(each) for each in installed()]
    show(found, is_json)
    return 0
