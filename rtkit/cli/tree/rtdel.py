"""``rtdel``: remove names from the tree."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rtkit.cli.shared.app import App, check_at_most_one
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, flag
from rtkit.errors import Malformed, NotFound, Partial, Refused, RtkitError, Unreachable, from_kind

if TYPE_CHECKING:
    from rtkit.deployment.actions import Action
    from rtkit.deployment.listing import Listing
    from rtkit.rtc.names import Path
    from rtkit.tree.client import Tree
    from rtkit.tree.view import TreeNode

_Failure = tuple[str, RtkitError]


@command(
    "rtdel",
    examples=(
        ("rtdel -z", "Remove everything that nobody is behind any more."),
        ("rtdel /localhost/old.host_cxt", "Remove a directory, that is every name in it."),
        ("rtdel -z /localhost/Robot0.rtc", "Remove a name, but only if it is a zombie's."),
    ),
    arguments=("deletable",),
)
def main(
    app: App,
    zombies: bool = flag("-z --zombies", "Zombies only; without a path: all of them."),
    paths: tuple[str, ...] = arguments("[PATH]"),
) -> None:
    """Remove names from the tree.

    Only the name goes: a component lives on, and is found below its manager; a manager too, and
    answers at its direct address. Of a directory all names in it are removed. With its last name
    a zombie is forgotten. Components are ended by rtexit, those that hang by rtexit --force.
    """
    check_at_most_one(paths, "path")
    if paths:
        path = app.path(paths[0])
        _raise(_remove(app.tree, _below(app, path, zombies)))
    elif zombies:
        _remove_zombies(app)
    else:
        raise Malformed("No path given.")


def _remove_zombies(app: App) -> None:
    """Remove the zombies of every known manager; a silent manager holds up no other."""
    from rtkit.tree.connect import connect

    failures = _remove(app.tree, _all_zombies(app.tree.listing()))
    for name in app.others():
        try:
            with connect(name, app.timeout_s) as tree:
                failures += _remove(tree, _all_zombies(tree.listing()))
        except Unreachable as error:
            failures.append((name, error))
    _raise(failures)


def _below(app: App, path: Path, zombies: bool) -> list[Action]:
    from rtkit.deployment.actions import Unregister
    from rtkit.tree.resolve import present
    from rtkit.tree.view import NodeKind, build

    if path.port is not None:
        raise Malformed(f"Undeletable object: {path.typed}")
    if not path.elements:
        raise Malformed("Cannot delete the root directory.")
    listing = app.tree.listing()
    node = present(build(listing), path, listing.host)
    if zombies and node.kind is not NodeKind.ZOMBIE:
        raise Refused(f"Not a zombie object: {path.typed}")
    if node.kind is NodeKind.HOST:
        raise Refused(f"Undeletable object: {path.typed}")
    if node.parent is None or node.parent.kind is NodeKind.MANAGER:
        raise Refused(f"Parent not a directory: {path.typed}")
    return [Unregister(name, zombies) for name in _names(listing, node)]


def _names(listing: Listing, node: TreeNode) -> list[str]:
    """Return the names behind an entry, or behind all entries of a directory."""
    from rtkit.tree.view import NodeKind, shown_path

    registered = [*listing.names, *(name for row in listing.rows for name in row.names)]
    shown = [(name, shown_path(name, listing.host)) for name in registered]
    if node.kind is NodeKind.DIRECTORY:
        return [name for name, place in shown if place.startswith(f"{node.path}/")]
    return [name for name, place in shown if place == node.path]


def _all_zombies(listing: Listing) -> list[Action]:
    from rtkit.deployment.actions import Delete, Unregister

    actions: list[Action] = []
    for row in listing.rows:
        if row.zombie:
            actions += [Unregister(name, is_zombie=True) for name in row.names]
            # A component that lost its name while it lived is only below its manager.
            actions += [] if row.names else [Delete(row.instance)]
    return actions


def _remove(tree: Tree, actions: Sequence[Action]) -> list[_Failure]:
    """Remove all names and return those that remain."""
    from rtkit.deployment.actions import Delete, Unregister

    if not actions:
        return []
    results = tree.apply(actions, is_ordered=False)
    failures: list[_Failure] = []
    for action, result in zip(actions, results, strict=True):
        # Somebody else removed it in the meantime: the request is fulfilled.
        if not result.ok and result.kind != NotFound.kind:
            assert isinstance(action, Unregister | Delete)
            what = f"/{action.name}" if isinstance(action, Unregister) else action.instance
            failures.append((what, from_kind(result.kind, result.why)))
    return failures


def _raise(failures: Sequence[_Failure]) -> None:
    if len(failures) == 1:
        raise failures[0][1]
    if failures:
        raise Partial("the others are removed", failures)
