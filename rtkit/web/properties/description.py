"""Describes property pages: what is drawn for a property, a service, or a page put together.

The widgets are those that a service describes (``P.gui``), dressed with components by type; where
it describes none they come from the types. Names are whole targets, so a page may have properties
of several services.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from hashlib import sha256
from typing import Any

from rtkit.api.asked import Ask
from rtkit.api.client import Client
from rtkit.panel.description import Panel, dressed, read_panel
from rtkit.panel.dressing import own_form, service_of_components, words_of, worn
from rtkit.panel.generic import generic
from rtkit.property.codes import PropertyError
from rtkit.property.values import Element
from rtkit.property.writing import write
from rtkit.web.properties.property_services import PropertyServices

_BOUND_S = 2.0
_PLACE = "location"
_MOVETO = ".behaviors.moveto"
_WITHOUT_GUI = frozenset({"unknown", "syntax", "bad-parameter", "bad-value", "read-only"})
_MOST_ITEMS = 200


class PropertyDescriptions:
    """Asks services what they want drawn; calls block, each for 2 s or less."""

    def __init__(self, client: Client, services: PropertyServices) -> None:
        self._client = client
        self._services = services

    def of(self, target: str) -> Panel:
        """Return the widgets of a property or service; names are whole targets.

        Raises:
            PropertyError: It cannot be reached, or is not there.
        """
        try:
            panel = read_panel(str(self._client.payload(Ask(f"{target}.gui"), _BOUND_S)))
        except PropertyError as error:
            if error.code not in _WITHOUT_GUI:
                raise
            return self._of_types(target)
        service = target[: len(target) - len(panel.name)].rstrip("./")
        store = self._components(panel, service)
        of_type = self._of_type(store, "text")
        panel = worn(panel, service, self._component, lambda word: self._component(of_type(word)))
        panel = _whole(self._with_html(panel, service, store), service)
        if panel.kind == "group" and panel.name == service:
            return self._with_map(panel, service)
        return panel

    def of_page(self, page: Panel) -> Panel:
        """Return the widgets of a page that was put together.

        A child with a name stands for a property, and its attributes for those of its widget; one
        without is a group. All that is drawn as a map in one group is one map.
        """
        if sum(1 for _ in page.all()) > _MOST_ITEMS:
            raise PropertyError("too-large", f"a page has {_MOST_ITEMS} properties at most")
        children = [each if each.name else self.of_page(each) for each in page.children]
        maps = [each.name for each in children if each.name and each.kind == "map"]
        items: list[Panel] = []
        for each in children:
            if each.kind == "map" and each.name in maps[1:]:
                continue
            more = {"layers": self._layers_of(maps, children)} if each.name in maps[:1] else {}
            items.append(self._item(each, more) if each.name else each)
        return Panel({"kind": "group", "label": page.attributes.get("label", "")}, tuple(items))

    def _layers_of(self, maps: Sequence[str], items: Iterable[Panel]) -> str:
        """Return all that the map of a page shows besides its own property."""
        goals = [each.name for each in items if each.name.endswith(_MOVETO)]
        known = (*maps, *self._services.layers(), *goals)
        return _words(each for each in dict.fromkeys(known) if each != maps[0])

    def _item(self, item: Panel, more: Mapping[str, str]) -> Panel:
        try:
            found = self.of(item.name)
        except PropertyError as error:
            attributes = {"kind": "label", "name": item.name, "access": "r", "away": str(error)}
            found = Panel(attributes)
        is_group = found.kind == "group"
        mine = ("label",) if is_group else ("label", "kind", "min", "max", "step")
        asked = {key: text for key, text in item.attributes.items() if key in mine}
        label = {} if is_group else {"label": item.name}
        frame = {"frame": "world"} if "layers" in more else {}
        changed = Panel({**label, **asked, **more, **frame})
        return dressed(found, changed)

    # Components that services bring along

    def _components(self, panel: Panel, service: str) -> str:
        """Return the GUI service whose components are put on, empty if there is none."""
        mounted = service_of_components(panel)
        found = [f"{service}.{mounted}"] if mounted else self._services.of_type("gui")
        return next(iter(found), "")

    def _of_type(self, store: str, form: str) -> Any:
        known = self._services.names(store, all=1) if store else []

        def of_type(word: str) -> str:
            return f"{store}.{word}.{form}" if f"{word}.{form}" in known else ""

        return of_type

    def _component(self, target: str) -> Panel | None:
        if not target:
            return None
        try:
            return read_panel(str(self._client.payload(Ask(target), _BOUND_S)))
        except PropertyError:
            return None

    def _with_html(self, panel: Panel, service: str, store: str) -> Panel:
        """Return widgets that tell where there is HTML for them, and which version."""
        of_type = self._of_type(store, "html")

        def one(each: Panel) -> Panel:
            target = f"{service}.{each.name}" if each.name else service
            own = own_form(target, each, "html") if "html" in each.texts("forms") else ""
            html = own or next(filter(None, map(of_type, words_of(each))), "")
            more = {"html": html, "version": self._version(html)} if html else {}
            children = tuple(map(one, each.children))
            return each._replace(attributes={**each.attributes, **more}, children=children)

        return one(panel)

    def _version(self, target: str) -> str:
        try:
            code = str(self._client.payload(Ask(target), _BOUND_S))
        except PropertyError:
            return ""
        return sha256(code.encode("utf-8", "replace")).hexdigest()[:12]

    # Widgets that no service describes

    def _of_types(self, target: str) -> Panel:
        names = self._services.names(target)
        if not names:
            return self._of_type_alone(target)
        below = tuple(self._of_type_alone(f"{target}.{each}") for each in names[:_MOST_ITEMS])
        return Panel({"kind": "group", "name": target}, below)

    def _of_type_alone(self, target: str) -> Panel:
        meta = value = None
        try:
            found = self._client.get(f"{target}.meta")
            meta = found if isinstance(found, Element) else None
        except PropertyError:
            pass  # an owner that tells no types: the value has one
        try:
            value = self._client.get(target)
        except PropertyError:
            if meta is None:
                raise
        return generic(target, meta, value)

    # Maps

    def _with_map(self, panel: Panel, service: str) -> Panel:
        """Return widgets with a map of where the service is, and what it knows of, if it tells."""
        place = f"{service}.{_PLACE}"
        has_place = any(each.name == place and each.kind == "vector" for each in panel.children)
        is_model = "environment" in panel.texts("type")
        if not (has_place or is_model):
            return panel
        name = place if has_place else f"{service}.markers"
        layers = [each for each in self._services.layers() if each != name]
        layers += [each.name for each in panel.all() if has_place and each.name.endswith(_MOVETO)]
        seen = {"kind": "map", "name": name, "label": "map", "access": "r", "frame": "world"}
        drawn = Panel({**seen, "layers": _words(layers)})
        rest = tuple(each for each in panel.children if has_place or each.name != name)
        return panel._replace(children=(drawn, *rest))


def _words(names: Iterable[str]) -> str:
    return write(tuple(names))


def _whole(panel: Panel, service: str) -> Panel:
    """Return widgets whose names are whole targets; arguments keep theirs."""
    name = f"{service}.{panel.name}" if panel.name else service
    layers = [f"{service}.{each}" for each in panel.texts("layers")]
    more = {"layers": _words(layers)} if layers else {}
    children = tuple(_whole(each, service) for each in panel.children)
    return panel._replace(attributes={**panel.attributes, "name": name, **more}, children=children)


def watched(panel: Panel) -> Iterator[str]:
    """Yield what a page shows: its properties that can be read, and the layers of its maps."""
    for each in panel.all():
        is_read = "r" in each.attributes.get("access", "rw")
        if each.kind != "group" and not each.is_round and is_read:
            yield each.name
        yield from each.texts("layers")
