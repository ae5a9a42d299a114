"""Names that modules of Python have no more, in sources of Python 2 and of older versions of 3."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from rtkit.openrtm.migrate.python2_names import IsBeside, imported_modules, unguarded
from rtkit.openrtm.migrate.source_edits import Edit, SourcePlaces

_NEW_NAMES = {
    "base64": {"decodestring": "decodebytes", "encodestring": "encodebytes"},
    "configparser": {"SafeConfigParser": "ConfigParser"},
    "inspect": {"getargspec": "getfullargspec"},
    "os": {"getcwdu": "getcwd"},
    "string": {
        "letters": "ascii_letters", "lowercase": "ascii_lowercase", "uppercase": "ascii_uppercase",
    },
    "sys": {"maxint": "maxsize"},
    "time": {"clock": "perf_counter"},
}  # fmt: skip
_METHODS = {
    "configparser": {"readfp": "read_file"},
    "gettext": {"ugettext": "gettext", "ungettext": "ngettext"},
}
"""Methods of what a module makes, which no other module calls so."""
_NEW_MODULES = {"dummy_threading": "threading"}
_NO_MODULES = {
    "asyncore": "Python 3.12 has no asyncore: asyncio takes its place",
    "distutils": "Python 3.12 has no distutils: setuptools has the same",
    "imp": "Python 3.12 has no imp: importlib takes its place",
    "md5": "Python 3 has no md5: hashlib.md5 takes its place, and bytes",
    "sha": "Python 3 has no sha: hashlib.sha1 takes its place, and bytes",
}
_COLLECTIONS = frozenset(
    {
        "Callable", "Container", "Hashable", "ItemsView", "Iterable", "Iterator", "KeysView",
        "Mapping", "MappingView", "MutableMapping", "MutableSequence", "MutableSet", "Sequence",
        "Set", "Sized", "ValuesView",
    }
)  # fmt: skip
"""What is in `collections.abc` alone since Python 3.10."""
_CLOCK = "time.clock told processor time on Linux, perf_counter tells the time that passes"
_STRING_METHODS = frozenset(
    {
        "capitalize", "center", "count", "find", "ljust", "lower", "lstrip", "replace", "rfind",
        "rjust", "rstrip", "split", "strip", "swapcase", "upper", "zfill",
    }
)  # fmt: skip
"""Functions of module string whose first argument has them as a method."""
_STRING_FUNCTIONS = {"atof": "float", "atoi": "int", "maketrans": "str.maketrans"}
_XML = ("xml", "lxml")


def is_lost(module: str, name: str) -> bool:
    """Return whether a module of Python had an attribute that it has no more."""
    if module == "collections":
        return name in _COLLECTIONS
    functions = {"join", *_STRING_METHODS, *_STRING_FUNCTIONS} if module == "string" else ()
    return name in functions or name in _NEW_NAMES.get(module, ())


class Loss(NamedTuple):
    """A place of a source that fails.

    Attributes:
        what: Name that is there no more.
        edits: What mends it; empty where that is not certain.
        remark: What a person should know; empty for nothing.
    """

    line: int
    what: str
    edits: tuple[Edit, ...]
    remark: str = ""


def losses(tree: ast.Module, data: bytes, is_beside: IsBeside) -> Iterator[Loss]:
    """Yield what a source uses that is there no more, but for what it guards.

    Args:
        tree: The source, parsed.
        data: The same in UTF-8.
        is_beside: Tells the siblings that it imports in place of modules of Python.
    """
    modules = imported_modules(tree)
    found = _Losses(data, {n: m for n, m in modules.items() if not is_beside(m)}, is_beside, tree)
    for node in unguarded(tree):
        match node:
            case ast.Import():
                yield from found.of_import(node)
            case ast.ImportFrom(module=str(module), level=0):
                if not is_beside(module.partition(".")[0]):
                    yield from found.of_names(node, module)
            case ast.Attribute():
                yield from found.of_attribute(node)
            case ast.Call(func=ast.Attribute() as function):
                yield from found.of_call(node, function)
            case ast.Assign(targets=[ast.Tuple()], value=ast.Call(func=ast.Attribute()) as value):
                yield from found.of_unpacking(value)
            case ast.Expr(value=ast.Call(func=ast.Attribute()) as value):
                yield from found.of_statement(node, value)


class _Losses:
    def __init__(
        self, data: bytes, modules: Mapping[str, str], is_beside: IsBeside, tree: ast.Module
    ) -> None:
        self._places = SourcePlaces(data)
        self._modules = modules
        self._is_beside = is_beside
        nodes = list(ast.walk(tree))
        within = {str(each.module) for each in nodes if isinstance(each, ast.ImportFrom)}
        self._used = within | set(modules.values())
        attributes = (each for each in nodes if isinstance(each, ast.Attribute))
        self._has_abc = any(map(self._is_abc, attributes))

    def _is_abc(self, node: ast.Attribute) -> bool:
        return node.attr in _COLLECTIONS and self._module(node.value) == "collections"

    def of_import(self, node: ast.Import) -> Iterator[Loss]:
        """Yield the modules that are there no more, or not as a whole."""
        for each in node.names:
            top = each.name.partition(".")[0]
            if self._is_beside(top):
                continue
            if each.name in _NEW_MODULES:
                text = f"{_NEW_MODULES[each.name]} as {each.asname or each.name}"
                yield Loss(node.lineno, f"module {each.name}", (self._places.whole(each, text),))
            elif top in _NO_MODULES:
                yield Loss(node.lineno, f"module {top}", (), _NO_MODULES[top])
            elif each.name == "collections" and self._has_abc:
                other = f", collections as {each.asname}" if each.asname else ""
                edit = self._places.whole(each, f"collections.abc{other}")
                yield Loss(node.lineno, "collections", (edit,))

    def of_names(self, node: ast.ImportFrom, module: str) -> Iterator[Loss]:
        """Yield the names that are imported of a module which has them no more."""
        top, names = module.partition(".")[0], [each.name for each in node.names]
        if top in _NO_MODULES:
            yield Loss(node.lineno, f"module {top}", (), _NO_MODULES[top])
        elif module in _NEW_MODULES:
            yield self._instead(node, f"module {module}", _import(_NEW_MODULES[module], node.names))
        elif module == "collections" and _COLLECTIONS.intersection(names):
            lost = [each for each in node.names if each.name in _COLLECTIONS]
            others = [each for each in node.names if each not in lost]
            texts = [_import("collections.abc", lost)]
            texts += [_import("collections", others)] if others else []
            yield self._instead(node, f"collections.{lost[0].name}", "; ".join(texts))
        elif (module, names) == ("string", ["maketrans"]):
            local = node.names[0].asname or "maketrans"
            yield self._instead(node, "string.maketrans", f"{local} = str.maketrans")
        for each in node.names:
            new = _NEW_NAMES.get(module, {}).get(each.name)
            if new:
                edit = self._places.whole(each, f"{new} as {each.asname or each.name}")
                yield self._loss(node, module, each.name, edit)

    def _instead(self, node: ast.stmt, what: str, text: str) -> Loss:
        return Loss(node.lineno, what, (self._places.whole(node, text),))

    def _loss(self, node: ast.stmt | ast.expr, module: str, name: str, *edits: Edit) -> Loss:
        remark = _CLOCK if (module, name) == ("time", "clock") else ""
        return Loss(node.lineno, f"{module}.{name}", edits, remark)

    def of_attribute(self, node: ast.Attribute) -> Iterator[Loss]:
        """Yield an attribute that its module has no more, or what the module makes."""
        name, places = node.attr, self._places
        module = self._module(node.value)
        new = _NEW_NAMES.get(module, {}).get(name)
        if self._is_abc(node):
            new = f"abc.{name}"
        if new:
            yield self._loss(node, module, name, places.attribute(node, new))
        for maker, methods in _METHODS.items():
            if name in methods and maker in self._used:
                yield self._loss(node, maker, name, places.attribute(node, methods[name]))

    def of_call(self, node: ast.Call, function: ast.Attribute) -> Iterator[Loss]:
        """Yield a call of a function, or of a method, that is there no more."""
        name, places = function.attr, self._places
        if self._module(function.value) == "string":
            edits: tuple[Edit, ...] = ()
            if name in _STRING_FUNCTIONS:
                edits = (places.whole(function, _STRING_FUNCTIONS[name]),)
            elif name == "join" or name in _STRING_METHODS:
                edits = self._as_method(node, name)
            else:
                return
            remark = "" if edits else f"Python 3 has no string.{name}: texts have it as a method"
            yield Loss(node.lineno, f"string.{name}", edits, remark)
        if name == "getchildren" and not node.args and self._has_xml():
            begin = places.begin(node)
            edits = (
                Edit(begin, begin, "list("),
                Edit(places.end(function.value), places.end(node), ")"),
            )
            yield Loss(node.lineno, "getchildren", edits)
        if name == "isAlive" and "threading" in self._used:
            why = "threads have is_alive in place of isAlive since Python 3.9"
            yield Loss(node.lineno, "isAlive", (), why)

    def _has_xml(self) -> bool:
        return any(each.partition(".")[0] in _XML for each in self._used)

    def _as_method(self, node: ast.Call, name: str) -> tuple[Edit, ...]:
        """Return how a function of module string becomes a method; empty where it is not plain."""
        places, arguments = self._places, node.args
        if node.keywords or not arguments or not all(map(_is_atom, arguments[:2])):
            return ()
        begin, end = places.begin(node), places.end(node)
        first = arguments[0]
        if name != "join":
            rest = places.begin(arguments[1]) if arguments[1:] else places.end(first)
            return (
                Edit(begin, places.begin(first), ""),
                Edit(places.end(first), rest, f".{name}("),
            )
        separator = places.text(arguments[1]) if arguments[1:] else "' '"
        return (
            Edit(begin, places.begin(first), f"{separator}.join("),
            Edit(places.end(first), end, ")"),
        )

    def of_unpacking(self, call: ast.Call) -> Iterator[Loss]:
        """Yield where what getfullargspec tells beyond getargspec has no variables."""
        if self._is(call, "inspect", "getargspec"):
            end = self._places.end(call)
            yield Loss(call.lineno, "inspect.getargspec", (Edit(end, end, "[:4]"),))

    def of_statement(self, node: ast.stmt, call: ast.Call) -> Iterator[Loss]:
        """Yield a statement that has become superfluous."""
        if self._is(call, "sys", "setdefaultencoding"):
            yield self._instead(node, "sys.setdefaultencoding", "pass")

    def _is(self, call: ast.Call, module: str, name: str) -> bool:
        function = call.func
        return (
            isinstance(function, ast.Attribute)
            and function.attr == name
            and self._module(function.value) == module
        )

    def _module(self, node: ast.expr) -> str:
        return self._modules.get(node.id, "") if isinstance(node, ast.Name) else ""


def _import(module: str, names: list[ast.alias]) -> str:
    return ast.unparse(ast.ImportFrom(module, names, 0))


def _is_atom(node: ast.expr) -> bool:
    """Return whether a dot may follow an expression, which has no parentheses around it."""
    return isinstance(node, ast.Name | ast.Attribute | ast.Call | ast.Subscript | ast.List) or (
        isinstance(node, ast.Constant) and isinstance(node.value, str)
    )
