"""The tree as the naming service that programs for OpenRTM-aist look components up in."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from rtkit.errors import NotFound
from rtkit.openrtm.absent import refuse
from rtkit.openrtm.corba.cos_naming import Binding, Names, NamingContext, to_name, to_text
from rtkit.openrtm.corba.exceptions import CorbaException
from rtkit.openrtm_scripts.far_references import FarComponent, asked, the_tree
from rtkit.rtc.names import LOCAL, parse_path
from rtkit.tree.resolve import entry, node_at
from rtkit.tree.view import TreeNode

_SERVER = re.compile(r"(?:corbaname:|corbaloc:)?(?:iiop)?:?(?P<host>[^:/]*)")


class NamesInTree(NamingContext):
    """A host, or a folder, of the tree.

    Attributes:
        path: Where it is.
    """

    def __init__(self, path: str) -> None:
        self.path = path

    def resolve(self, name: Sequence[Any]) -> Any:
        """Return the component, or the folder, that has a name here.

        Raises:
            CorbaException: None has it, or the manager does not run.
        """
        path = f"{self.path}/{to_text(name)}"
        found = self._node(path, name)
        return FarComponent(path) if found.instance else NamesInTree(path)

    def list(self, how_many: int) -> tuple[list[Binding], None]:
        """Return all names here, however many are asked for, and that there are no more."""
        entries = self._node(self.path, []).entries()
        kinds = (Names.nobject, Names.ncontext)
        return [Binding(to_name(each.name), kinds[each.is_directory]) for each in entries], None

    def _node(self, path: str, name: Sequence[Any]) -> TreeNode:
        where = parse_path(path)

        def find() -> TreeNode | None:
            try:
                return node_at(the_tree().led_to(where), where, entry)
            except NotFound:
                return None

        found = asked(find)
        if found is None:
            raise self.NotFound(0, list(name))
        return found

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        raise refuse(f"CosNaming.NamingContext.{name}")


def root(host: str = LOCAL) -> NamesInTree:
    """Return the place that has the names of a host."""
    return NamesInTree(f"/{host}")


class CorbaNaming:
    """``OpenRTM_aist.CorbaNaming``: names of a server are those in the tree of its host."""

    def __init__(self, orb: Any = None, name_server: str = "") -> None:
        self.init(name_server)

    def init(self, name_server: str) -> None:
        """Look at another server: its host counts, as the tree names it."""
        found = _SERVER.match(name_server)
        self._root = root((found and found["host"]) or LOCAL)

    def isAlive(self) -> bool:
        """Return whether names can be looked up."""
        try:
            self._root.list(0)
        except CorbaException:
            return False
        return True

    def getRootContext(self) -> NamesInTree:
        """Return the place that has all names."""
        return self._root

    def resolve(self, name: Any) -> Any:
        """Return what has a name: a text, or a list of its elements.

        Raises:
            CorbaException: Nothing has it, or the manager does not run.
        """
        return self._root.resolve(to_name(name) if isinstance(name, str) else name)

    resolveStr = resolve

    def toName(self, sname: str) -> list[Any]:
        """Return the elements of a name."""
        return to_name(sname)

    def toString(self, name_list: Sequence[Any]) -> str:
        """Return a name as text."""
        return to_text(name_list)

    def list(self, name_cxt: NamesInTree, how_many: int, rbl: list[Any], rbi: list[Any]) -> None:
        """Put the bindings of a place into a list."""
        bindings, _ = name_cxt.list(how_many)
        rbl[:], rbi[:] = [bindings], [None]

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        raise refuse(f"CorbaNaming.{name}")
