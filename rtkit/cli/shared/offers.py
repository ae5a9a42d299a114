"""Lists the component types that a manager can create: from modules loaded or found."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from rtkit.rtc.create import parse_create

if TYPE_CHECKING:
    from rtkit.deployment.facts import Snapshot
    from rtkit.tree.client import Tree


class Offers(NamedTuple):
    """Component types that can be created, and the modules that cannot be described.

    Attributes:
        types: The module's file by the type's id of six fields; empty where it is loaded.
        problems: File of a module, and why it cannot be described.
    """

    types: dict[str, str]
    problems: list[tuple[str, str]]


def offers(tree: Tree, snapshot: Snapshot) -> Offers:
    """Ask a manager for the component types that it can create.

    Raises:
        Unreachable: It does not answer in time.
    """
    types = {each.full_id: "" for module in snapshot.modules for each in module.types}
    problems = []
    for line in tree.get("get_loadable_modules").splitlines():
        name, _, text = line.partition("?")
        options = parse_create(f"x?{text}").options if text else {}
        if "problem" in options:
            problems.append((name, options["problem"]))
        else:
            types[name] = options.get("module", "")
    return Offers(dict(sorted(types.items())), problems)
