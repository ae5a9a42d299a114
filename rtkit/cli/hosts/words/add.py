"""``rthost add``: know a host by a name."""

from __future__ import annotations

from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, flag, option, several


@command(
    "add",
    is_local=True,
    examples=(
        ("rthost add robot1 pi@192.168.1.7", "Known as /robot1 from now on."),
        ("rthost add arm arm.local:2222 --tag gpu", "With a tag, which requirements name."),
        ("rthost add arm arm.local --extra sim", "Its rtkit gets numpy, which a world needs."),
        ("rthost add arm arm.local --index https://pypi.org/simple", "It fetches wheels itself."),
        ("rthost add robot2 tls:10.0.0.7:2811", "Over mutual TLS: its manager has --tls."),
    ),
    arguments=("words",),
)
def main(
    app: App,
    python: str = option("--python FILE", "Interpreter there (default python3).", default=""),
    manager: str = option("--manager NAME", "Manager there (default manager).", default=""),
    tags: tuple[str, ...] = several("--tag WORD", "Word by which requirements choose it."),
    extras: tuple[str, ...] = several("--extra NAME", "What its rtkit is made with, as sim."),
    index: str = option("--index URL", "Simple index from which it fetches wheels.", default=""),
    is_forced: bool = flag("--force", "Replace a host of that name."),
    words: tuple[str, ...] = arguments("NAME [USER@]ADDRESS[:PORT]|tls:ADDRESS:PORT"),
) -> None:
    """Add a host to the inventory of the user.

    NAME is its name in the tree, /NAME. ADDRESS is a name, an IP address (IPv6 in brackets), or a
    Host of ~/.ssh/config. With tls: it is that of a manager with a port for certificates (rtmgr
    start --tls), which an administrator links without an account there; it is started there.
    Nothing is asked of the host: rthost check does that. With --index rtmgr start --host has it
    fetch the wheels that were chosen here, by their SHA-256; the others are sent.
    """
    from rtkit.errors import Refused
    from rtkit.fast_dataclass import replace
    from rtkit.hosts import inventory
    from rtkit.hosts.host import host_at
    from rtkit.link import host_links
    from rtkit.settings.inventory_files import user_file

    if len(words) != 2:
        raise WrongArguments("takes a name and an address")
    found = host_at(*words)
    host = replace(
        found,
        python=python or found.python,
        manager=manager or found.manager,
        tags=tags,
        extras=tuple(sorted(set(extras))),
        index=index,
    )
    if host_links.is_linked(host.name) and host.name not in inventory.read():
        raise Refused(f"another host is linked as {host.name}: rtmgr stop --host ends that first")
    inventory.add(host, is_forced=is_forced)
    app.verbose(f"{host.name} is in {user_file()}")
