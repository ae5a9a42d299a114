"""Turns the edits that a page sends into edits of a profile, each with a sentence.

What comes from an included file, or has a variable in its name, is changed where it stands.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from rtkit.errors import Malformed, NotFound, Refused
from rtkit.fast_dataclass import replace
from rtkit.profile import rts_model as rts
from rtkit.profile_tools import set_edits
from rtkit.profile_tools import system_edits as edits
from rtkit.profile_tools.new_system import NewMember, default_instance
from rtkit.profile_tools.stating import Statement, stated
from rtkit.profile_tools.system_edits import Key
from rtkit.web.documents.component_types import TypeStock
from rtkit.web.documents.document import Document
from rtkit.web.documents.document_view import misfit, records_of_view
from rtkit.web.fields import object_in, text_in, texts_in, words_in, wrong
from rtkit.web.live.steps import Action, listed

_HOST = "localhost"
_MARGIN = 40
_FAR = 1_000_000
_MOST_BENDS = 100
Edited = tuple[rts.RtsProfile, str]


def edited(document: Document, edit: Action, types: TypeStock) -> Edited:
    """Return a document after an edit, and what the edit does, as a sentence.

    Raises:
        Malformed: It is no edit; names what is wrong.
        NotFound: What it is about is not there.
        Refused: It makes no sense here; says why.
    """
    verb = text_in(edit, "do")
    if verb == "add":
        return _add(document, edit, types)
    if verb not in _EDITS:
        raise Malformed(f"do: there is no edit {verb!r}; there are add, {', '.join(_EDITS)}")
    return _EDITS[verb](document, edit)


def _add(document: Document, edit: Action, types: TypeStock) -> Edited:
    type = types.profile(text_in(edit, "type"))
    assert type.basic_info is not None
    taken = [each.instance_name for each in document.view.profile.components]
    name = text_in(edit, "name", "") or default_instance(type.basic_info.name, taken)
    place = _place(edit["at"]) if "at" in edit else _free_place(document)
    profile = edits.added(document.profile, NewMember(type, name), _HOST, place)
    return profile, f"Add {name}"


def _free_place(document: Document) -> tuple[int, int] | None:
    """Return a place below all that is drawn; None where the layout places everything."""
    if document.view.keys and not document.places():
        return None
    layout = document.layout(records_of_view(document.view, document.catalogue), [])
    places = document.places()
    boxes = [{**box, **places.get(id, {})} for id, box in layout["boxes"].items()]
    lowest = max((box["y"] + box["height"] for box in boxes), default=0)
    return min((box["x"] for box in boxes), default=_MARGIN), lowest + _MARGIN


def _remove(document: Document, edit: Action) -> Edited:
    components, connectors = words_in(edit, "components"), words_in(edit, "connectors")
    keys = [_own(document, each) for each in components]
    known = {each["id"] for each in _wires(document)}
    for each in connectors:
        if each not in known:
            raise NotFound(f"No such connector: {each}")
        _check_origin(document, each)
    what = [listed("component", components)] if components else []
    what += [listed("connector", connectors)] if connectors else []
    if not what:
        raise Malformed("components, connectors: nothing is named that is to go")
    return edits.removed(document.profile, keys, connectors), f"Remove {' and '.join(what)}"


def _rename(document: Document, edit: Action) -> Edited:
    id, name = text_in(edit, "component"), text_in(edit, "name")
    return edits.with_name(document.profile, _own(document, id), name), f"Rename {id} to {name}"


def _connect(document: Document, edit: Action) -> Edited:
    paths = text_in(edit, "source"), text_in(edit, "target")
    ends = [document.view.end(path) for path in paths]
    why = misfit(ends[0].port, ends[1].port)
    if why:
        raise Refused(f"{paths[0]} and {paths[1]} cannot be connected: {why}")
    for end in ends:
        _check_own(document, end.owner)
    profile = edits.connected(document.profile, ends[0], ends[1], texts_in(edit, "properties"))
    return profile, f"Connect {paths[0]} to {paths[1]}"


def _connector(document: Document, edit: Action) -> Edited:
    id = text_in(edit, "connector")
    _check_origin(document, id)
    profile = edits.with_connector_properties(document.profile, id, _values(edit, "properties"))
    return profile, f"Set properties of the connector {id}"


def _move(document: Document, edit: Action) -> Edited:
    places = edit.get("places")
    if not isinstance(places, dict):
        raise Malformed("places: an object is wanted")
    moved = {_own(document, id): _place(at) for id, at in places.items()}
    return edits.placed(document.profile, moved), f"Move {', '.join(places)}"


def _resize(document: Document, edit: Action) -> Edited:
    id = text_in(edit, "component")
    key = _own(document, id)
    width, height = _numbers(edit, "width", "height")
    if width < 1 or height < 1:
        raise Malformed(f"a size is above 0, not {width} x {height}")
    profile = edits.located(document.profile, key, _drawn(document, id), size=(width, height))
    return profile, f"Resize {id}"


def _turn(document: Document, edit: Action) -> Edited:
    id, direction = text_in(edit, "component"), text_in(edit, "direction")
    key = _own(document, id)
    if direction not in edits.DIRECTIONS:
        raise Malformed(f"direction: {', '.join(edits.DIRECTIONS)}, not {direction!r}")
    profile = edits.located(document.profile, key, _drawn(document, id), direction=direction)
    return profile, f"Turn {id} {direction}"


def _bend(document: Document, edit: Action) -> Edited:
    id, points = text_in(edit, "connector"), edit.get("points")
    _check_origin(document, id)
    if not isinstance(points, list) or len(points) > _MOST_BENDS:
        raise Malformed(f"points: a list of {_MOST_BENDS} places at most is wanted")
    corners = [_place(each) for each in points]
    return edits.bent(document.profile, id, corners), f"Bend the connector {id}"


def _drawn(document: Document, id: str) -> tuple[int, int]:
    """Return where a component is drawn, whether by its profile or by the layout."""
    layout = document.layout(records_of_view(document.view, document.catalogue), [])
    at = document.places().get(id) or layout["boxes"].get(id, {"x": _MARGIN, "y": _MARGIN})
    return max(at["x"], 1), at["y"]


def _arrange(document: Document, _edit: Action) -> Edited:
    layout = document.layout(records_of_view(document.view, document.catalogue), [])
    keys = document.view.keys
    own = {edits.key_of(each) for each in document.profile.components}
    places = {
        keys[id]: (box["x"] + _MARGIN, box["y"] + _MARGIN)
        for id, box in layout["boxes"].items()
        if keys[id] in own
    }
    return edits.placed(document.profile, places), "Arrange all"


def _configure(document: Document, edit: Action) -> Edited:
    name, values = text_in(edit, "set"), _values(edit, "values")
    sentence = f"Set {', '.join(values)} of {text_in(edit, 'component')}"
    return _of_component(
        document, edit, lambda each: set_edits.configured(each, name, values)
    ), sentence


def _add_set(document: Document, edit: Action) -> Edited:
    name, source = text_in(edit, "set"), text_in(edit, "source", "")
    profile = _of_component(document, edit, lambda each: set_edits.with_set(each, name, source))
    return profile, f"Add the set {name} to {text_in(edit, 'component')}"


def _remove_set(document: Document, edit: Action) -> Edited:
    name = text_in(edit, "set")
    profile = _of_component(document, edit, lambda each: set_edits.without_set(each, name))
    return profile, f"Remove the set {name} of {text_in(edit, 'component')}"


def _activate_set(document: Document, edit: Action) -> Edited:
    name = text_in(edit, "set")
    profile = _of_component(document, edit, lambda each: set_edits.with_active_set(each, name))
    return profile, f"Make {name} the active set of {text_in(edit, 'component')}"


def _require(document: Document, edit: Action) -> Edited:
    is_required = edit.get("is_required") is True
    profile = _of_component(document, edit, lambda each: replace(each, is_required=is_required))
    word = "required" if is_required else "optional"
    return profile, f"Make {text_in(edit, 'component')} {word}"


def _state(document: Document, edit: Action) -> Edited:
    """State a property of a component, or of the system where none is named."""
    id, key = text_in(edit, "component", ""), text_in(edit, "key")
    value = None if edit.get("value") is None else text_in(edit, "value")
    instance = _own(document, id).instance_name if id else ""
    profile = stated(document.profile, [Statement(instance, key, value)])
    return profile, f"Set {key} of {id or 'the system'}"


def _identify(document: Document, edit: Action) -> Edited:
    vendor, name, version = (text_in(edit, key) for key in ("vendor", "name", "version"))
    profile = document.profile
    if (vendor, name, version) != edits.identity(profile):
        profile = edits.identified(profile, vendor, name, version)
    abstract, comment = text_in(edit, "abstract", ""), text_in(edit, "comment", "")
    # Nothing and an empty text are two things in a profile: one that was left alone stays.
    if (abstract, comment) != (profile.abstract or "", profile.comment or ""):
        profile = replace(profile, abstract=abstract or None, comment=comment or None)
    log = words_in(edit, "log")
    if tuple(log) != profile.version_up_logs:
        profile = replace(profile, version_up_logs=tuple(log))
    return profile, "Change what the profile tells of itself"


_EDITS: Mapping[str, Callable[[Document, Action], Edited]] = {
    "remove": _remove,
    "rename": _rename,
    "connect": _connect,
    "connector": _connector,
    "move": _move,
    "arrange": _arrange,
    "resize": _resize,
    "turn": _turn,
    "bend": _bend,
    "configure": _configure,
    "add_set": _add_set,
    "remove_set": _remove_set,
    "activate_set": _activate_set,
    "require": _require,
    "state": _state,
    "identify": _identify,
}


def _of_component(
    document: Document,
    edit: Action,
    change: Callable[[rts.ComponentInstance], rts.ComponentInstance],
) -> rts.RtsProfile:
    return edits.changed(document.profile, _own(document, text_in(edit, "component")), change)


def _own(document: Document, id: str) -> Key:
    """Return the identity of a component that this file states itself."""
    key = document.view.key(id)
    _check_own(document, key)
    return key


def _check_own(document: Document, key: Key) -> None:
    ids = {each: id for id, each in document.view.keys.items()}
    _check_origin(document, ids[key])
    if all(edits.key_of(each) != key for each in document.profile.components):
        raise Refused(f"{ids[key]} has its name from a variable: change it in the file")


def _check_origin(document: Document, id: str) -> None:
    file = document.view.origins.get(id)
    if file:
        raise Refused(f"{id} comes from {file}, which this profile includes: change it there")


def _wires(document: Document) -> Sequence[Mapping[str, object]]:
    records = records_of_view(document.view, document.catalogue)
    return list(records.connectors.values())


def _values(edit: Action, key: str) -> dict[str, str | None]:
    """Return texts of an edit by their names; None for what is to go."""
    texts = object_in(edit, key)
    if not texts:
        raise wrong(key, "an object with texts", texts)
    return {name: None if texts[name] is None else text_in(texts, name) for name in texts}


def _place(value: object) -> tuple[int, int]:
    """Return a place [pixel].

    Raises:
        Malformed: It is none.
    """
    return _numbers(value, "x", "y")


def _numbers(value: object, *keys: str) -> tuple[int, int]:
    """Return two lengths [pixel].

    Raises:
        Malformed: They are none.
    """
    given = value if isinstance(value, dict) else {}
    numbers = [given.get(key) for key in keys]
    found = [round(each) for each in numbers if isinstance(each, int | float) and abs(each) < _FAR]
    if len(found) != len(numbers):
        raise Malformed(f"{' and '.join(keys)} are numbers [pixel], not {value!r}")
    return found[0], found[1]
