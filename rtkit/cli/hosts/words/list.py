"""``rthost list``: which hosts are known, and which are linked."""

from __future__ import annotations

from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, json_flag


@command(
    "list",
    is_local=True,
    examples=(
        ("rthost list", "Name, address, whether it is linked, tags."),
        ("rthost list --json", "The same, for another program."),
    ),
    json=("host",),
    arguments=(),
)
def main(app: App, is_json: bool = json_flag(), words: tuple[str, ...] = arguments("")) -> None:
    """List the known hosts, and how the links to them are; no host is asked."""
    from rtkit.hosts import inventory
    from rtkit.link import host_links

    if words:
        raise WrongArguments(f"takes no arguments: {words[0]}")
    known = inventory.read()
    records = []
    for name in sorted({*known, *host_links.hosts()}):
        host = known.get(name)
        why = host_links.read(name).why if host_links.is_linked(name) else None
        records.append(
            {
                "name": name,
                "address": str(host) if host is not None else None,
                "is_linked": why == "",
                "why": why or ("" if why is not None else "not linked: rtmgr start --host"),
                "tags": [*host.tags] if host is not None else [],
            }
        )
    if is_json:
        terminal.write(json_records.line("host", record) for record in records)
        return
    rows = [
        [
            str(each["name"]),
            str(each["address"] or "in no inventory"),
            "linked" if each["is_linked"] else str(each["why"]),
            " ".join(map(str, each["tags"])),  # type: ignore[arg-type]
        ]
        for each in records
    ]
    terminal.write(terminal.table(rows))
