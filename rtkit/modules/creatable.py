"""Checks whether modules and component types could be found, without running any of them."""

from __future__ import annotations

import json
import os.path
from collections.abc import Collection, Sequence

from rtkit.component.composite import TYPES as COMPOSITES
from rtkit.errors import Malformed, NotFound, Refused
from rtkit.modules.describing import describe
from rtkit.modules.known import instead
from rtkit.modules.search import Search, is_among
from rtkit.rtc.create import CreateString, parse_create
from rtkit.rtc.profiles import ModuleProfile, TypeProfile, split_module

_STAR = b"import *"


def lacking(
    question: str, loaded: Collection[ModuleProfile], search: Search, *, is_search_allowed: bool
) -> str:
    """Return for each pair of a module and a create string why nothing can be made of it.

    What only shows when code runs is not found: empty means that nothing speaks against it.

    Args:
        question: JSON, ``[["PATH:INIT", "CREATE"], …]``; no module is an empty text.
        loaded: The modules that are loaded.
        search: Where modules are looked for.
        is_search_allowed: Whether they are also found by the names of types.

    Returns:
        JSON, a text for each pair.

    Raises:
        Malformed: The question is none.
    """
    try:
        asked = [(str(module), str(create)) for module, create in json.loads(question)]
    except (TypeError, ValueError) as error:
        raise Malformed(f"not pairs of a module and a create string: {error}") from error
    finder = _Finder(loaded, search, is_search_allowed=is_search_allowed)
    return json.dumps([finder.lack(module, parse_create(create)) for module, create in asked])


class _Finder:
    def __init__(
        self, loaded: Collection[ModuleProfile], search: Search, *, is_search_allowed: bool
    ) -> None:
        self._loaded = {module.path: module for module in loaded}
        self._types = [kind for module in loaded for kind in module.types]
        self._search = search
        self._is_search_allowed = is_search_allowed

    def lack(self, module: str, create: CreateString) -> str:
        """Return why a component cannot be made with a module; empty when it may be."""
        path, init = split_module(module)
        offered: Sequence[TypeProfile] = ()
        if path and path not in self._loaded:
            try:
                found = self._offered(path, init)
            except (NotFound, Refused, Malformed) as error:
                return str(error)
            if found is None:
                return ""  # its types are known only when it runs
            offered = found
        if create.implementation_id in COMPOSITES or is_among(create, (*self._types, *offered)):
            return ""
        return self._not_found(create, path, offered)

    def _offered(self, path: str, init: str) -> Sequence[TypeProfile] | None:
        """Return the types that a module plainly offers; None where that is not known.

        Raises:
            NotFound: There is no such file, or no such function in it.
            Refused: It may not be loaded.
            Malformed: It is no Python.
        """
        source = self._search.read(path)
        name = init or source.init
        if name and name.encode() not in source.text and _STAR not in source.text:
            raise NotFound(f"no init function {name} in module {path}")
        try:
            found = describe(source.text, source.file, name, source.package)
        except Malformed as error:
            if str(error).startswith("SyntaxError"):
                raise Malformed(f"module does not import: {error}") from error
            return None
        return [offer.type for offer in found] if found else None

    def _not_found(self, create: CreateString, path: str, offered: Sequence[TypeProfile]) -> str:
        name = create.implementation_id
        own = self._search.path_of(create)
        may_search = self._is_search_allowed and os.path.basename(name) == name
        if may_search and own not in self._loaded and self._search.has(own):
            try:
                found = self._offered(own, "")
            except (NotFound, Refused, Malformed) as error:
                return str(error)
            if found is None or is_among(create, found):
                return ""
        named = [kind.type_name for kind in (*self._types, *offered)]
        if name in named:
            there = [k.full_id for k in (*self._types, *offered) if k.type_name == name]
            return f"component type {name} is not known so; there is {', '.join(there)}"
        message = f"component type {name} is not known"
        if path and offered:
            return f"{message}; module {path} offers {', '.join(k.type_name for k in offered)}"
        looked = f" (looked in {', '.join(self._search.folders)} and among installed packages)"
        search = self._search if self._is_search_allowed else None
        more = instead(name, named, COMPOSITES, search)
        return f"{message}{looked if may_search else ''}{more}"
