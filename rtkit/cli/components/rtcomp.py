"""``rtcomp``: make and change composite components."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from rtkit.cli.shared.app import App, check_at_most_one
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, option, several, strict_option
from rtkit.errors import Malformed, NotFound, Refused, from_kind
from rtkit.rtc.names import COMPONENT_SUFFIX

if TYPE_CHECKING:
    from rtkit.deployment.actions import Action
    from rtkit.deployment.facts import ComponentFacts, Snapshot
    from rtkit.deployment.listing import Listing
    from rtkit.rtc.names import Path
    from rtkit.tree.view import TreeNode

DEFAULT_NAME = "CompositeRTC"
DEFAULT_TYPE = "PeriodicECSharedComposite"
_SET = "default"
_MEMBERS = "members"
_PORTS = "exported_ports"


@command(
    "rtcomp",
    examples=(
        (
            "rtcomp -a Sensor0.rtc:range -a Control0.rtc /localhost/manager.mgr:Robot0",
            "Make a composite of two components that shows a port of the first.",
        ),
        ("rtcomp -a Control0.rtc:speed Robot0.rtc", "Show another port."),
        ("rtcomp -r Sensor0.rtc Robot0.rtc", "Let a member go, with the ports shown of it."),
        (
            "rtcomp -t GroupingComposite -a Left.rtc -a Right.rtc /localhost/manager.mgr:Wheels",
            "Only group components: each keeps its own execution context.",
        ),
    ),
    arguments=("manager|component",),
    values={"-a": "component:", "-r": "component:", "-t": "composite-type"},
)
def main(
    app: App,
    added: tuple[str, ...] = several("-a --add MEMBER[:PORTS]", "Add, and show ports."),
    removed: tuple[str, ...] = several(
        "-r --remove MEMBER[:PORTS]", "Remove; with ports only hide these."
    ),
    options: str = option("-o --options OPTIONS", "KEY=VALUE&... for one to be made.", default=""),
    kind: str = option("-t --type TYPE", f"Default: {DEFAULT_TYPE}.", default=DEFAULT_TYPE),
    strict: None = strict_option(),
    targets: tuple[str, ...] = arguments("MANAGER[:NAME]|COMPOSITE"),
) -> None:
    """Make and change composite components.

    With a manager the composite of that NAME, by default CompositeRTC, is made, or changed if it is
    there already. PORTS are names of the member's ports with commas between; the composite shows
    them as INSTANCE.PORT. Added members come last in the order of execution. All members have to be
    in one process. Without -a and -r an empty composite is made. Its context, which drives all
    members, runs at 1000 Hz unless -o says another rate: -o 'exec_cxt.periodic.rate=100'.
    """
    if not targets:
        raise Malformed("No manager or existing composite component specified.")
    check_at_most_one(targets, "manager or composite")
    create = f"{kind}?{options.lstrip('&')}" if options else kind
    _change(app, app.path(targets[0]), added, removed, create)


def _change(
    app: App, path: Path, added: Sequence[str], removed: Sequence[str], create: str
) -> None:
    from rtkit.tree.resolve import present
    from rtkit.tree.view import build

    listing = app.tree.listing()
    root = build(listing)
    node = present(root, path, listing.host)
    name = _name(node, path)
    adding = [_added(root, listing, app.path(each)) for each in added]
    removing = [_removed(root, listing, app.path(each)) for each in removed]
    snapshot = app.tree.part(list(dict.fromkeys([name, *(each.instance for each in adding)])))
    for each in adding:
        _check_ports(snapshot, each)
    whole = snapshot.component(name)
    if whole is not None and not whole.zombie:
        _edit(app, snapshot, whole, path, adding, removing)
    elif removing:
        raise Refused("Cannot remove components/ports from a new composition.")
    else:
        _make(app, create, name, node.process if node.is_slave else "", adding)


def _name(node: TreeNode, path: Path) -> str:
    """Return the instance name of the composite that is meant."""
    from rtkit.rtc.names import check_instance_name
    from rtkit.tree.resolve import zombie
    from rtkit.tree.view import NodeKind

    if node.kind is NodeKind.MANAGER:
        return check_instance_name(path.port) if path.port is not None else DEFAULT_NAME
    if node.is_directory:
        raise Refused(f"Not a component or manager: {path.typed}")
    if path.port is not None or path.is_directory:
        raise Malformed(f"Not a component: {path.typed}")
    if node.kind is NodeKind.ZOMBIE:
        raise zombie(node, path)
    return node.instance


def _added(root: TreeNode, listing: Listing, path: Path) -> MemberChange:
    from rtkit.tree.resolve import component, component_of_port

    is_bare = path.port is None
    find = component if is_bare else component_of_port
    node = find(root, path, listing.host)
    return MemberChange(path, node.instance, _ports(path))


def _removed(root: TreeNode, listing: Listing, path: Path) -> MemberChange:
    """Return the member to remove; one that has gone is known by the last part of its path."""
    from rtkit.tree.resolve import find

    node = find(root, path, listing.host)
    is_component = path.elements and (node is None or not node.is_directory)
    if not is_component or path.is_directory:
        raise Refused(f"Not a component: {path.typed}")
    gone = path.elements[-1].removesuffix(COMPONENT_SUFFIX)
    return MemberChange(path, gone if node is None else node.instance, _ports(path))


def _ports(path: Path) -> tuple[str, ...]:
    return tuple(each for each in (path.port or "").split(",") if each)


def _check_ports(snapshot: Snapshot, change: MemberChange) -> None:
    facts = snapshot.component(change.instance)
    if facts is None:
        raise NotFound(f"No such object: {change.path.typed}")
    for port in change.ports:
        if facts.port(port) is None:
            raise NotFound(f"Port not found: {change.typed_port(port)}")


def _make(app: App, create: str, name: str, slave: str, adding: Sequence[MemberChange]) -> None:
    from rtkit.deployment.actions import Create, strict
    from rtkit.rtc.create import parse_create

    wished = parse_create(create)
    made = wished.with_options(
        instance_name=name,
        manager_name=wished.place or slave,
        **Parts((), ()).with_added(adding).values,
    )
    action = Create(str(made))
    (result,) = app.tree.apply([strict(action) if app.is_strict else action])
    if not result.ok:
        raise from_kind(result.kind, f"Failed to create component: {made} ({result.why})")
    if result.note:
        app.fail(f"note: {result.note}")


def _edit(
    app: App,
    snapshot: Snapshot,
    whole: ComponentFacts,
    path: Path,
    adding: Sequence[MemberChange],
    removing: Sequence[MemberChange],
) -> None:
    from rtkit.deployment.actions import ActivateSet, SetParameters

    if not whole.composite_type:
        raise Refused(f"Not a composite component: {path.typed}")
    for change in adding:
        _check_process(snapshot, whole, change)
    given = whole.sets.get(_SET, {})
    parts = parts_of(given).without(removing).with_added(adding)
    if parts == parts_of(given):
        return
    actions: list[Action] = [
        SetParameters(whole.instance, _SET, parts.values),
        ActivateSet(whole.instance, _SET),
    ]
    for result in app.tree.apply(actions):
        result.raise_for_error()


def _check_process(snapshot: Snapshot, whole: ComponentFacts, change: MemberChange) -> None:
    facts = snapshot.component(change.instance)
    if facts is not None and facts.process != whole.process:
        raise Refused(
            f"{change.path.typed} is in {facts.process}, {whole.instance} in {whole.process}:"
            " members of a composite are in one process"
        )


class MemberChange(NamedTuple):
    """A member to be added or removed, or only ports of it."""

    path: Path
    instance: str
    ports: tuple[str, ...]

    @property
    def names(self) -> list[str]:
        """The names under which the composite shows these ports."""
        return [f"{self.instance}.{port}" for port in self.ports]

    def typed_port(self, port: str) -> str:
        """Return the path of one of these ports as the user typed it."""
        return f"{self.path.typed.rpartition(':')[0]}:{port}"


class Parts(NamedTuple):
    """Members and shown ports of a composite, by name."""

    members: tuple[str, ...]
    ports: tuple[str, ...]

    @property
    def values(self) -> dict[str, str]:
        """The parameters of a composite with these parts."""
        return {_MEMBERS: ",".join(self.members), _PORTS: ",".join(self.ports)}

    def with_added(self, changes: Iterable[MemberChange]) -> Parts:
        """Return these with members added, and ports of members shown."""
        members, ports = list(self.members), list(self.ports)
        for change in changes:
            members.append(change.instance)
            ports += change.names
        return Parts(tuple(dict.fromkeys(members)), tuple(dict.fromkeys(ports)))

    def without(self, changes: Iterable[MemberChange]) -> Parts:
        """Return these without some members, or without some ports of members.

        Raises:
            NotFound: It is no member, or its port is not shown.
        """
        members, ports = self
        for change in changes:
            if change.instance not in self.members:
                raise NotFound(f"Not a member: {change.path.typed}")
            if change.ports:
                self._check_shown(change)
                ports = tuple(name for name in ports if name not in change.names)
            else:
                prefix = f"{change.instance}."
                members = tuple(name for name in members if name != change.instance)
                ports = tuple(name for name in ports if not name.startswith(prefix))
        return Parts(members, ports)

    def _check_shown(self, change: MemberChange) -> None:
        for port, name in zip(change.ports, change.names, strict=True):
            if name not in self.ports:
                raise NotFound(f"Port not found: {change.typed_port(port)}")


def parts_of(values: Mapping[str, str]) -> Parts:
    """Return the parts that the parameters of a composite name."""
    return Parts(_split(values.get(_MEMBERS, "")), _split(values.get(_PORTS, "")))


def _split(text: str) -> tuple[str, ...]:
    return tuple(name.strip() for name in text.split(",") if name.strip())
