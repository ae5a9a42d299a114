"""Runs every command: common options, the connection to the tree, errors to exit statuses.

A command file declares its options and calls one room. It is a console script (``rtls``), a verb
of the unified tool (``rtkit ls``) and a function: ``main(["-l"], tree=some_tree)``.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import click

from rtkit.cli.shared.terminal import printable
from rtkit.errors import Malformed, NotFound, Refused, RtkitError, Unreachable

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from rtkit.deployment.facts import ComponentFacts
    from rtkit.deployment.plan_watch import PlanWatch
    from rtkit.rtc.manager_address import Address
    from rtkit.rtc.names import Path
    from rtkit.settings.layer_file import SettingsFile
    from rtkit.settings.layers import Layers
    from rtkit.tree.client import Tree
    from rtkit.tree.view import TreeNode

Node = TypeVar("Node")
DEFAULT_TIMEOUT_S = 10.0
_LEAST_TIMEOUT_S = 2.0
"""Least time-out for a manager on a busy machine [s]."""


class App:
    """One run of a command.

    Attributes:
        name: Words that the user typed to get here, the prefix of every message.
        timeout_s: Time-out of each call [s].
        is_verbose: Report progress on stderr, and tracebacks.
        is_strict: Take warnings for errors.
        form: ``xml``, ``yaml`` or ``json`` where an option says what the profile is.
        sets: ``KEY=VALUE`` for a system profile, as typed.
        values: Files of such values.
        prefix: Text before all names of a system profile.
        command: The subcommand that is run, once that is known.
        layers: Files of settings; None in a function, for which only its arguments count.
        given: Settings of those files that count, by key.
        watch: Receives plans and what becomes of their steps, as records; None for lines.
        write_error: Writes one line on stderr.
        needs_reader: Whether it ends when nobody reads its stdout any more.
    """

    def __init__(self, name: str, tree: Tree | None = None) -> None:
        self.name = name
        self.timeout_s = DEFAULT_TIMEOUT_S
        self.is_verbose = False
        self.is_strict = False
        self.watch: PlanWatch | None = None
        self.form: str | None = None
        self.has_exit_detail = _is_set("RTKIT_EXIT_DETAIL")
        self.layers: Layers | None = None
        self.given: Mapping[str, SettingsFile] = {}
        self.sets: tuple[str, ...] = ()
        self.values: tuple[str, ...] = ()
        self.prefix = ""
        self.command: click.Command | None = None
        self.needs_reader = True
        self.write_error: Callable[[str], object] = _to_stderr
        self._tree = tree
        self._is_own_tree = tree is None
        self._beside: dict[str, Tree] = {}
        self._place: str | None = None
        self._has_warned_of_servers = False
        self.missed = 0

    @property
    def tree(self) -> Tree:
        """The connection to the manager, made at first use."""
        if self._tree is None:
            from rtkit.tree.connect import connect

            self._tree = connect(self._place or "", self.timeout_s)
        return self._tree

    @property
    def manager(self) -> str:
        """The name, or address, of the manager that is asked, whether it runs or not."""
        if self._tree is not None:
            return self._tree.manager
        from rtkit.link.places import usual_manager

        return self._place or usual_manager()

    def read_settings(self) -> None:
        """Read the files of settings, and have them count where the environment says nothing.

        Raises:
            RtkitError: One of them is wrong.
        """
        from rtkit.settings import layers

        self.layers = layers.read(_commands)
        self.given = self.layers.apply()
        self.has_exit_detail = _is_set("RTKIT_EXIT_DETAIL")
        for text in self.layers.warnings:
            self.fail(f"warning: {text}")

    def defaults(self, name: str, command: click.Command) -> dict[str, Any] | None:
        """Return the values of a command's options that nobody typed, by parameter.

        Raises:
            Malformed: Names the place of a wrong one.
        """
        if self.layers is None:
            return None
        from rtkit.settings.layers import has_variables

        if not (self.layers.files or has_variables()):
            return None
        from rtkit.cli.shared.defaults import default_map

        return default_map(name, command, self.layers, self.given)

    def ask(self, tree: Tree) -> None:
        """Use a connection that was made for this run; it is closed with the run."""
        self._tree = tree

    def root(self, path: Path, *, is_deep: bool) -> tuple[TreeNode, str]:
        """Return the tree as far as a path shows it, and the host that ``localhost`` means.

        A deep tree asks the other managers of this host too.
        """
        if self._is_own_tree:
            from rtkit.tree.place import root_for

            self._warn_of_servers()
            return root_for(lambda: self.tree, path, is_deep=is_deep)
        from rtkit.tree.view import build

        listing = self.tree.listing()
        return build(listing), listing.host

    def node(self, how: Callable[[TreeNode, Path, str], Node], path: Path) -> Node:
        """Return what `how`, a function of `rtkit.tree.resolve`, finds at a path.

        It gets the root of the tree, the path, and the host that ``localhost`` means.
        """
        from rtkit.tree.resolve import node_at

        return node_at(self.tree, path, how)

    def facts(self, path: Path) -> ComponentFacts:
        """Return the facts of the living component at a path.

        Raises:
            NotFound: None is there.
        """
        from rtkit.tree.resolve import component

        instance = self.node(component, path).instance
        facts = self.tree.part([instance]).component(instance)
        if facts is None:
            raise NotFound(f"No such object: {path.typed}")
        return facts

    def _warn_of_servers(self) -> None:
        """Warn, once, of entries of RTKIT_SERVERS that cannot be asked."""
        from rtkit.tree.place import strange_servers

        if not self._has_warned_of_servers:
            self._has_warned_of_servers = True
            self.warn(strange_servers())

    def report_silent(self, root: TreeNode, nodes: Iterable[TreeNode], done: str) -> int:
        """Report managers that did not answer, where nothing was `done`; return the exit status.

        Args:
            root: Root of the tree; it knows whether the manager asked has answered.
            nodes: Nodes to look at.
            done: The operation on them, ``searched``.
        """
        from rtkit.tree.view import silent

        texts = [root.trouble] if root.trouble else []
        texts += [f"{node.path} was not {done}: {node.trouble}" for node in silent(nodes)]
        for text in texts:
            self.fail(text)
        return self.status(Unreachable()) if texts else 0

    def report_silent_servers(self, done: str) -> int:
        """Report permanent servers of the tree that do not answer; return the exit status."""
        if not self._is_own_tree:
            return 0
        from rtkit.tree.place import silent_servers

        self._warn_of_servers()
        silent = silent_servers(self.timeout_s)
        for why in silent:
            self.fail(f"{done}: {why}")
        return self.status(Unreachable()) if silent else 0

    def others(self) -> list[str]:
        """Return the other known managers, each as `connect` takes it."""
        if not self._is_own_tree:
            return []
        from rtkit.tree.place import others

        return others(self.tree)

    @property
    def finds_managers(self) -> bool:
        """Return whether this run looks for managers itself, because none was given."""
        return self._is_own_tree

    @property
    def usual_manager(self) -> str:
        """Return the manager of components whose path names none."""
        from rtkit.link.places import usual_manager

        return usual_manager()

    def wait_for(self, sources: Iterable[int], until: float | None) -> set[int]:
        """Wait until descriptors are readable and return those; none when the time is up.

        Raises:
            BrokenPipeError: Nobody reads stdout any more.
        """
        from rtkit.cli.shared.stdout_reader import wait_for

        return wait_for(sources, until, needs_reader=self.needs_reader)

    def counting(self, title: str) -> AbstractContextManager[Callable[[int, int], None]]:
        """Return a context with what shows how many actions are done, of how many."""
        from rtkit.cli.shared.progress import counting

        return counting(self, title)

    def at(self, address: Address) -> tuple[Tree, str]:
        """Return the connection to the manager at an address, and the slave that it names, if any.

        Raises:
            Unreachable: No manager answers there, or another one than is meant.
        """
        from rtkit.tree.connect import connect_near, slave_at

        if self._tree is None:
            self._place = str(address)
            self._tree, slave = connect_near(address, self.timeout_s)
            return self._tree, slave
        asked = self._tree.manager
        if address.id not in ("", asked):
            raise Unreachable(f"manager {address.id!r} is not the one asked: {asked!r}")
        return self._tree, slave_at(address, asked)

    def path(self, typed: str) -> Path:
        """Read a path as typed, relative to the working directory in the tree.

        The path also selects the manager to ask.

        Raises:
            Refused: Another path led to another manager.
        """
        from rtkit.rtc.names import parse_path

        path = parse_path(typed, working_directory())
        self.note_place(path)
        return path

    def beside(self, typed: str) -> Path:
        """Read a further path, which may lead to another manager; `tree_at` connects to that."""
        from rtkit.rtc.names import parse_path

        return parse_path(typed, working_directory())

    def is_at_tree(self, path: Path) -> bool:
        """Return whether a path leads to the manager that `tree` is connected to."""
        if not self._is_own_tree:
            return True
        from rtkit.tree.place import manager_of

        return manager_of(path) == (self._place or "")

    def tree_at(self, path: Path) -> Tree:
        """Return the connection to the manager that a path leads to.

        Raises:
            Unreachable: It does not run, or does not answer.
        """
        if self.is_at_tree(path):
            return self.tree
        from rtkit.tree.connect import connect
        from rtkit.tree.place import manager_of

        place = manager_of(path)
        if place not in self._beside:
            self._beside[place] = connect(place, self.timeout_s)
        return self._beside[place]

    def shown(self, names: Sequence[str]) -> str:
        """Return the path that a user can type for a component of the manager asked, if any."""
        if not names or not self._is_own_tree:
            return f"/{names[0]}" if names else ""
        from rtkit.tree.place import shown

        return shown(names[0], self.tree.manager, self._place or "")

    def note_place(self, path: Path) -> None:
        """Record the manager that a path selects.

        Raises:
            Refused: Another path led to another manager.
        """
        if not self._is_own_tree:
            return
        from rtkit.tree.place import manager_of

        place = manager_of(path)
        if self._place is None:
            self._place = place
        elif place != self._place:
            raise Refused(
                f"{path.typed} is at another manager ({place or 'the usual one'}"
                f" instead of {self._place or 'the usual one'}): one command asks one manager"
            )

    def report(self, text: str) -> None:
        """Write a line, or several, on stderr."""
        for line in text.split("\n"):
            self.write_error(printable(line))

    def fail(self, text: str) -> None:
        """Write one line on stderr behind the command's name."""
        self.write_error(printable(f"{self.name}: {text}"))

    def miss(self, text: str) -> None:
        """Write the same, and end with the status of what cannot be reached."""
        self.fail(text)
        self.missed = self.status(Unreachable())

    def warn(self, texts: Iterable[str], mark: str = "warning: ") -> None:
        """Write warnings about a request before it is carried out.

        Raises:
            Malformed: There are any, and they are to be taken for errors.
        """
        found = list(texts)
        if found and self.is_strict:
            raise Malformed("; ".join(found))
        for text in found:
            self.fail(f"{mark}{text}")

    def verbose(self, text: str) -> None:
        """Write progress on stderr when asked to be verbose."""
        if self.is_verbose:
            self.report(text)

    def status(self, error: RtkitError) -> int:
        """Return the exit status that stands for `error`."""
        return error.detail if self.has_exit_detail else error.exit_code

    def bound(self, duration_s: float | None) -> None:
        """Limit the wait for a manager to the duration of the command, if that is known [s]."""
        if duration_s is not None:
            self.timeout_s = min(self.timeout_s, max(duration_s, _LEAST_TIMEOUT_S))

    def close(self) -> None:
        """End the connections that this run made."""
        for tree in self._beside.values():
            tree.close()
        self._beside.clear()
        if self._is_own_tree and self._tree is not None:
            self._tree.close()
            self._tree = None


def _commands() -> Collection[str]:
    from rtkit.cli.table import TOPICS

    return [name for names in TOPICS.values() for name in names if name.startswith("rt")]


def _is_set(variable: str) -> bool:
    return os.environ.get(variable, "") not in ("", "0")


def _to_stderr(line: str) -> None:
    click.echo(line, err=True)


def working_directory() -> str:
    """Return the place in the tree that relative paths start from."""
    return os.environ.get("RTKIT_CWD") or os.environ.get("RTCSH_CWD") or "/"


class WrongArguments(Malformed):
    """The number of arguments is wrong: the usage is shown, the exit status is 1."""


def check_at_most_one(words: Sequence[str], what: str) -> None:
    """Refuse more than one argument.

    Raises:
        WrongArguments: Names those that are too many.
    """
    if len(words) > 1:
        raise WrongArguments(f"takes one {what}, not also: {' '.join(words[1:])}")


def no_such(what: str, typed: str, known: Iterable[str]) -> str:
    """Return that a word is none of a few, with those that may have been meant, else all."""
    from rtkit.rtc.nearest import did_you_mean

    words = list(known)
    hint = did_you_mean(typed, words) or f" (one of {', '.join(words)})"
    return f"no such {what}: {typed}{hint}"
