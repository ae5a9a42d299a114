"""Scripting interface: the commands as methods of `rtkit.tree.client.Tree` that take paths."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rtkit.errors import Malformed, NotFound, Partial, Refused, RtkitError

Value = str | float
"""A value of a parameter or property: text, a number, or true and false."""

if TYPE_CHECKING:
    from typing import Protocol

    from rtkit.deployment.actions import Action, Result
    from rtkit.deployment.facts import ComponentFacts, Snapshot
    from rtkit.deployment.listing import Listing, ListingRow
    from rtkit.rtc.names import Path
    from rtkit.tree.view import TreeNode

    class _Calls(Protocol):
        host: str
        manager: str
        ticks: dict[tuple[str, int | str], Action]
        place: str

        def listing(self) -> Listing: ...

        def listing_at(self, paths: Sequence[Path]) -> Listing: ...

        def part(self, instances: Sequence[str]) -> Snapshot: ...

        def apply(
            self,
            actions: Sequence[Action],
            *,
            is_ordered: bool = True,
            timeout_s: float | None = None,
        ) -> tuple[Result, ...]: ...

        def perform(self, action: Action, *, timeout_s: float | None = None) -> str: ...

        def set(self, name: str, value: str) -> str: ...

        def _manager_at(self, path: Path) -> str: ...

        def led_to(self, path: Path) -> _Calls: ...


class ByPath:
    """Scripting methods of a `Tree`: the commands as methods that take paths.

    Paths are absolute, as ``rtls`` shows them and `create` returns them; they may lead to other
    managers, of this host or a linked one, which are connected to then. Every method is bounded by
    the time-out. An execution context is given by its number (own ones first, then those taken part
    in) or id.

    Example::

        with rtkit.connect() as tree:
            source = tree.create("ConsoleIn?instance_name=In0")
            sink = tree.create("ConsoleOut?manager_name=other")
            tree.connect(f"{source}:out", f"{sink}:in")
            for name in tree.ls("/localhost"):
                if name.endswith(".rtc"):
                    tree.activate(f"/localhost/{name}")
    """

    def ls(self: _Calls, path: str = "/localhost") -> list[str]:
        """Return the names of what is at a place, by name.

        Raises:
            NotFound: Nothing is there.
        """
        node = _entry(self.listing(), _read(path))
        return [child.name for child in node.entries()] if node.is_directory else [node.name]

    def component(self: _Calls, path: str) -> ComponentFacts:
        """Return everything known of a component: ``tree.component("/localhost/In0.rtc").state``.

        Raises:
            NotFound: Nothing is there.
            Refused: It is no component, or a zombie.
        """
        return _facts(self.led_to(_read(path)), path)

    def load(self: _Calls, path: str, init: str = "") -> None:
        """Have a module loaded: a file by its path, or by its name in a load path.

        Without `init` its init function is ``<name>Init``. Loading it again changes nothing.

        Raises:
            NotFound: There is no such file, or no such function in it.
            Refused: It does not import, or its init function raises; states where.
        """
        from rtkit.deployment.actions import Load

        self.perform(Load(path, init))

    def create(self: _Calls, text: str) -> str:
        """Create a component from a create string and return its path.

        If there is one of that instance name already, nothing is made and its path is returned.

        Example::

            path = tree.create("ConsoleIn?instance_name=In0&manager_name=slave1")
            tree.activate(path)

        Raises:
            NotFound: Nobody knows the component type.
            Malformed: The create string cannot be read.
            Refused: It could not be made.
        """
        from rtkit.deployment.actions import Create

        instance = self.perform(Create(as_text(text, "create string")))
        listing = self.listing()
        row = next(each for each in listing.rows if each.instance == instance)
        return _path_of(row, listing, self.place)

    def delete(self: _Calls, path: str) -> None:
        """Finalise a component, or forget a zombie: ``tree.delete("/localhost/In0.rtc")``.

        Raises:
            NotFound: Nothing is there.
            Refused: It is no component.
        """
        from rtkit.deployment.actions import Delete
        from rtkit.tree.resolve import check_component_syntax, entry, node_at

        where = _read(path)
        check_component_syntax(where)
        tree = self.led_to(where)
        node = node_at(tree, where, entry)
        if node.is_directory:
            raise Refused(f"Not a component: {path}")
        tree.perform(Delete(node.instance))

    def activate(self: _Calls, path: str, context: int | str = 0) -> None:
        """Make a component active in an execution context; returns when it is.

        Raises:
            Refused: Its state does not allow it.
        """
        _change(self.led_to(_read(path)), path, context, "activate")

    def deactivate(self: _Calls, path: str, context: int | str = 0) -> None:
        """Make a component inactive in an execution context; returns when it is.

        Raises:
            Refused: Its state does not allow it.
        """
        _change(self.led_to(_read(path)), path, context, "deactivate")

    def reset(self: _Calls, path: str, context: int | str = 0) -> None:
        """Bring a component from Error to Inactive; returns when it is.

        Raises:
            Refused: Its state does not allow it.
        """
        _change(self.led_to(_read(path)), path, context, "reset")

    def tick(
        self: _Calls, *paths: str, context: int | str = 0, timeout_s: float | None = None
    ) -> None:
        """Give components one cycle each, in this order; returns when the last one is over.

        Their contexts are not periodic: ``execution_contexts=ExtTrig`` in the create string. A
        path is looked up at its first tick, and after one that failed.

        Args:
            paths: The components.
            context: Number or id of the execution context.
            timeout_s: Bound on each cycle [s]; None for that of the connection.

        Raises:
            Refused: The context is periodic or does not run; or the component is a zombie, is not
                active, or fails in the cycle.
            NotFound: There is no such component, and none had a cycle.
            Unreachable: The cycle is not over in time: the slave has ended, or was stopped.
            Partial: That happened to one of several: those before it had their cycle, those
                after it had none. Its `failures` name it.
        """
        asked = [(path, context) for path in paths]
        for path, _ in asked:
            if (path, context) not in self.ticks:
                self.ticks[path, context] = _tick(self, path, context)
        results = self.apply([self.ticks[each] for each in asked], timeout_s=timeout_s)
        if all(result.ok for result in results):
            return
        failed = asked[len(results) - 1]
        del self.ticks[failed]
        try:
            results[-1].raise_for_error()
        except RtkitError as error:
            if len(paths) == 1:
                raise
            raise Partial(f"{failed[0]}: {error}", [(failed[0], error)]) from None

    def connect(
        self: _Calls,
        one: str,
        other: str,
        connector_id: str = "",
        *,
        connector_name: str = "",
        **properties: Value,
    ) -> str:
        """Connect two ports and return the connector's id.

        A dot in the name of a property is written as two underscores.

        Example::

            tree.connect("/localhost/In0.rtc:out", "/localhost/Out0.rtc:in",
                         dataport__subscription_type="flush")

        Raises:
            Refused: The ports do not fit.
        """
        from uuid import uuid4

        from rtkit.deployment.actions import Connect
        from rtkit.rtc.far_ends import host_of, named_by, peer_of
        from rtkit.tree.expecting import expected
        from rtkit.tree.wiring import find_ends_at, in_order, make_connector

        _, (first, second) = find_ends_at(self.led_to, [_port(one), _port(other)])
        given = {key.replace("__", "."): value_text(each, key) for key, each in properties.items()}
        connector = make_connector(
            first, second, connector_id or str(uuid4()), connector_name, given
        )
        out, into = in_order(first, second)
        expecting = []
        if host_of(peer_of(connector)):
            expecting = [(self.led_to(into.path), named_by(connector, out.manager))]
        with expected(expecting):
            return self.led_to(out.path).perform(Connect(connector))

    def disconnect(self: _Calls, one: str, other: str = "") -> int:
        """Remove the connections of a port, or those between two; return how many there were.

        Example::

            tree.disconnect("/localhost/In0.rtc:out")
        """
        from rtkit.deployment.actions import Disconnect
        from rtkit.tree.wiring import between_paths

        paths = [_port(path) for path in (one, other) if path != ""]
        tree, manager = self.led_to(paths[0]), self._manager_at(paths[0])
        is_near = lambda path: self._manager_at(path) == manager  # noqa: E731
        connectors = between_paths(tree, self.led_to, is_near, paths)
        for result in tree.apply([Disconnect(connector.connector_id) for connector in connectors]):
            result.raise_for_error()
        return len(connectors)


def as_text(value: object, what: str) -> str:
    """Return `value`, which must be text.

    Raises:
        TypeError: It is something else; names `what` it is for.
    """
    if not isinstance(value, str):
        raise TypeError(f"{what} is text, not {type(value).__name__}: {value!r}")
    return value


def _read(path: str) -> Path:
    from rtkit.rtc.names import parse_path

    return parse_path(as_text(path, "a path"))


def _port(path: str) -> Path:
    where = _read(path)
    if where.port is None:
        raise Malformed(f"Not a port: {path}")
    return where


def value_text(value: object, name: str) -> str:
    """Return a value of a parameter or property as the text that it is set by.

    Raises:
        TypeError: It is no value.
    """
    if isinstance(value, bool):
        return "true" if value else "false"
    return str(value) if isinstance(value, int | float) else as_text(value, f"value of {name}")


def _path_of(row: ListingRow, listing: Listing, place: str) -> str:
    """Return where a component is found: its first name, else the place below its manager."""
    from rtkit.rtc.names import COMPONENT_SUFFIX, LOCAL, MANAGER_SUFFIX
    from rtkit.tree.view import shown_path

    if row.names:
        return shown_path(row.names[0], listing.host, place)
    usual = f"{LOCAL}/{listing.manager}{MANAGER_SUFFIX}"
    manager = shown_path(listing.names[0] if listing.names else usual, listing.host, place)
    return f"{manager}/{row.instance}{COMPONENT_SUFFIX}"


def _entry(listing: Listing, where: Path) -> TreeNode:
    from rtkit.tree.resolve import entry
    from rtkit.tree.view import build

    return entry(build(listing), where, listing.host)


def _component(tree: _Calls, path: str) -> TreeNode:
    from rtkit.tree.resolve import component, node_at

    return node_at(tree, _read(path), component)


def _change(tree: _Calls, path: str, context: int | str, transition: str) -> None:
    from rtkit.deployment.actions import ChangeState
    from rtkit.rtc.enums import Transition

    node = _component(tree, path)
    id = context if isinstance(context, str) else _context(tree, node, context)
    tree.perform(ChangeState(node.instance, id, Transition(transition)))


def _tick(tree: _Calls, path: str, context: int | str) -> Action:
    from rtkit.deployment.actions import Tick

    node = _component(tree, path)
    return Tick(
        node.instance, context if isinstance(context, str) else _context(tree, node, context)
    )


def _context(tree: _Calls, node: TreeNode, index: int) -> str:
    if not isinstance(index, int) or isinstance(index, bool):
        raise TypeError(f"an execution context is a number or text, not {index!r}")
    if index == 0 and node.row is not None and node.row.context:
        return node.row.context
    facts = tree.part([node.instance]).component(node.instance)
    if facts is None or not 0 <= index < len(facts.contexts):
        raise Malformed(f"Bad execution context index: {index}")
    return facts.contexts[index].id


def _facts(tree: _Calls, path: str) -> ComponentFacts:
    instance = _component(tree, path).instance
    facts = tree.part([instance]).component(instance)
    if facts is None:
        raise NotFound(f"No such object: {path}")
    return facts
