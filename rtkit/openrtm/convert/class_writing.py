"""Writes the class of a component: its head, its callbacks, what is left of its setup."""

from __future__ import annotations

import ast
import re
import textwrap
from collections.abc import Iterator

from rtkit.openrtm.convert.bytes_for_text import mark_bytes
from rtkit.openrtm.convert.component_model import (
    OldComponent,
    OldParameter,
    OldPort,
    is_self,
    text_of,
)
from rtkit.openrtm.convert.data_plans import INLINE, LOCAL, DataPlan, plan_of
from rtkit.openrtm.convert.draft import API, ModuleDraft
from rtkit.openrtm.convert.expressions import ExpressionWriter
from rtkit.openrtm.convert.line_breaks import laid_out
from rtkit.openrtm.convert.naming import CALLBACKS, choose_names, rename_collisions
from rtkit.openrtm.convert.parameters import read_parameters
from rtkit.openrtm.convert.reading import ADDS, PREPARING, is_call_of_method, written_port
from rtkit.openrtm.convert.value_types import ValueTypes
from rtkit.openrtm.convert.values import initial_of, written_value

_BASE = f"{API}.DataFlowComponentBase"
_OK = "RTC.RTC_OK"
_WIDE = 99
_PURE = frozenset({"abs", "bool", "float", "int", "len", "list", "max", "min", "round", "str"})


def write_class(draft: ModuleDraft, component: OldComponent) -> None:
    """Write the native class of a component into the edits of its module."""
    read_parameters(draft, component)
    choose_names(draft, component)
    rename_collisions(draft, component)
    plans = {name: plan_of(draft, component, each) for name, each in component.data.items()}
    types = ValueTypes(draft, component)
    _find_lists(component, types)
    mark_bytes(draft, component, plans)
    docs = _take_docs(draft, component)
    _remove_setup(draft, component, plans)
    writer = ExpressionWriter(draft, component, plans, types)
    writer.write()
    _write_stores(draft, component, writer)
    for plan in plans.values():
        _write_data(draft, plan)
    _write_explicit(draft, component)
    _write_callbacks(draft, component)
    draft.source.settle()
    _write_setup(draft, component)
    _write_head(draft, component, docs)


def write_values(draft: ModuleDraft, beside: OldComponent) -> None:
    """Write what a function or class beside the components does with values of data types."""
    types = ValueTypes(draft, beside)
    _find_lists(beside, types)
    writer = ExpressionWriter(draft, beside, {}, types)
    writer.write()
    _write_stores(draft, beside, writer)


def _find_lists(component: OldComponent, types: ValueTypes) -> None:
    """Find variables that hold a received sequence, but are used as lists."""
    for node in ast.walk(component.node):
        is_tuple = isinstance(node, ast.Name) and types.is_tuple(node)
        if is_tuple and isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
            types.note_use(node)


def _take_docs(draft: ModuleDraft, component: OldComponent) -> dict[str, str]:
    """Return the texts that stand before what makes ports and parameters, and leave them out."""
    docs = {}
    for method in component.methods:
        if method.name not in PREPARING:
            continue
        text = ""
        for statement in method.body[bool(ast.get_docstring(method)) :]:
            if isinstance(statement, ast.Expr) and text_of(statement.value) is not None:
                text = text_of(statement.value) or ""
                draft.source.remove(statement)
            elif isinstance(statement, ast.Assign) and is_self(statement.targets[0]):
                if text.strip():
                    docs[statement.targets[0].attr] = text
                text = ""
    return docs


def _remove_setup(draft: ModuleDraft, component: OldComponent, plans: dict[str, DataPlan]) -> None:
    """Leave out the statements that the head of the native class says."""
    source = draft.source
    declared = {*component.ports, *component.parameters}
    for method in component.methods:
        for node in ast.walk(method):
            if isinstance(node, ast.Assign) and is_self(node.targets[0]):
                attribute = node.targets[0].attr
                if attribute in declared and method.name in PREPARING:
                    source.remove(node)
            elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
                if _is_setup(draft, component, node.value):
                    source.remove(node)
            elif isinstance(node, ast.Return) and _calls_base(draft, node.value):
                source.replace(node, "return")
    for statement in _descriptor_statements(draft, component):
        source.remove(statement)
    for plan in plans.values():
        for statement in plan.data.made_at:
            if plan.way in (INLINE, LOCAL):
                source.remove(statement)
        for store in plan.unused_stores():
            if _is_pure(store.value):
                source.remove(store)
        if not any(path[:1] == ("tm",) or not path for path in plan.leaves):
            for stamp in plan.data.stamps:
                source.remove(stamp)


def _descriptor_statements(draft: ModuleDraft, component: OldComponent) -> Iterator[ast.stmt]:
    """Yield the lists that early RTC Builders made as long as a type has fields: ``x_arg``."""
    for node in ast.walk(component.node):
        if not isinstance(node, ast.Assign) or not isinstance(node.targets[0], ast.Name):
            continue
        if any(draft.qualified(each).startswith("RTC._d_") for each in ast.walk(node.value)):
            name = node.targets[0].id
            uses = [
                each
                for each in ast.walk(draft.source.method(node) or component.node)
                if isinstance(each, ast.Name) and each.id == name and each is not node.targets[0]
            ]
            if all(isinstance(draft.source.parent(each), ast.Starred) for each in uses):
                yield node


def _is_pure(node: ast.expr) -> bool:
    """Return whether an expression does nothing but give a value."""
    calls = (each.func for each in ast.walk(node) if isinstance(each, ast.Call))
    return all(isinstance(each, ast.Name) and each.id in _PURE for each in calls)


def _calls_base(draft: ModuleDraft, node: ast.expr | None) -> bool:
    return node is not None and draft.call_of(node).startswith(f"{_BASE}.")


def _is_setup(draft: ModuleDraft, component: OldComponent, call: ast.Call) -> bool:
    name = draft.call_of(call)
    if name.startswith(f"{_BASE}."):
        return True
    function = call.func
    if not isinstance(function, ast.Attribute):
        return False
    if isinstance(function.value, ast.Call) and draft.qualified(function.value.func) == "super":
        return function.attr == "__init__" or function.attr in CALLBACKS
    if is_self(function) and function.attr in ADDS and len(call.args) > 1:
        return is_self(call.args[1]) and call.args[1].attr in component.ports
    if function.attr in ("addProperty", "appendProperty") and is_self(function.value):
        return _take_property(component, function.value.attr, call)
    if is_self(function, "bindParameter") and len(call.args) > 1 and is_self(call.args[1]):
        return call.args[1].attr in component.parameters
    return is_self(function.value, "_configsets") and function.attr == "update"


def _take_property(component: OldComponent, attribute: str, call: ast.Call) -> bool:
    """Note a property that a port is given; return whether the head of the class can say it."""
    port = component.ports.get(attribute)
    texts = [text_of(each) for each in call.args]
    if port is None or len(texts) != 2 or texts[0] is None or texts[1] is None:
        return False
    if texts[0] == "description":
        port.doc = texts[1]
    else:
        port.properties[texts[0]] = texts[1]
    return True


def _write_stores(draft: ModuleDraft, component: OldComponent, writer: ExpressionWriter) -> None:
    for node in ast.walk(component.node):
        if isinstance(node, (ast.Assign, ast.AugAssign)):
            if not draft.source.is_removed(node):
                writer.store_part(node)
        elif isinstance(node, ast.Expr):
            writer.stamp(node)


def _write_data(draft: ModuleDraft, plan: DataPlan) -> None:
    """Write what makes, stamps and writes a value that ports are bound to."""
    source = draft.source
    if plan.way not in (INLINE, LOCAL):
        for statement in plan.data.made_at:
            lines = [
                f"{text} = {initial_of(draft, plan, leaf, keeps_literals=True)}"
                for leaf, text in plan.leaves.items()
            ]
            source.replace(statement, f"\n{source.indent(statement)}".join(lines))
    for stamp in plan.data.stamps:
        if source.is_removed(stamp):
            continue
        now = f"{draft.native('Time')}.now()"
        root = plan.leaves.get(())
        name = plan.leaves.get(("tm",))
        if root:
            source.replace(stamp, f"{root} = {draft.replaced(root, 'tm', now)}")
        elif name:
            source.replace(stamp, f"{name} = {now}")
        else:
            draft.mark(stamp, "only a part of the time stamp is set elsewhere")
    for store in plan.unused_stores():
        if not source.is_removed(store):
            source.replace(store, source.render(store.value))
    for call, port in plan.data.writes:
        texts = dict(plan.leaves)
        run = plan.runs[call]
        if plan.way == INLINE:
            texts = {path: source.render(run[path].value) for path in plan.leaves}
            for each in run.values():
                source.remove(each)
        value = written_value(draft, plan, texts)
        source.replace(
            call,
            laid_out(f"self.{port.native}.write({value})", source.indent(source.statement(call))),
        )
        _check_result(draft, call)


def _check_result(draft: ModuleDraft, call: ast.Call) -> None:
    if not isinstance(draft.source.parent(call), ast.Expr):
        draft.mark(call, "write() returns a PortStatus, not whether the value went out")


def _write_explicit(draft: ModuleDraft, component: OldComponent) -> None:
    """Check writes of values that are no bound ones."""
    known = {id(call) for data in component.data.values() for call, _ in data.writes}
    for node in ast.walk(component.node):
        port = written_port(component, node) if isinstance(node, ast.Call) else None
        if port is None or id(node) in known:
            continue
        assert isinstance(node, ast.Call)
        _check_result(draft, node)
        if not node.args and not port.bound:
            value = f"{draft.data_name(port.cls)}()"
            draft.source.replace(node, f"self.{port.native}.write({value})")


def _write_callbacks(draft: ModuleDraft, component: OldComponent) -> None:
    """Give callbacks their native names, and have them return nothing where all is well."""
    for method in component.methods:
        native = CALLBACKS.get(method.name)
        if native is None:
            continue
        _annotate(draft, method)
        draft.source.rename_function(method, native)
        for argument in method.args.args[1:]:
            _write_context(draft, method, argument, native)
        returns = [each for each in ast.walk(method) if isinstance(each, ast.Return)]
        if all(each.value is None or draft.qualified(each.value) == _OK for each in returns):
            for each in returns:
                if each is method.body[-1]:
                    draft.source.remove(each)
                else:
                    draft.source.replace(each, "return")


def _annotate(draft: ModuleDraft, method: ast.FunctionDef) -> None:
    """Say what a callback returns."""
    codes = [
        each.value
        for each in ast.walk(method)
        if isinstance(each, ast.Return) and each.value is not None
    ]
    is_quiet = all(draft.qualified(each) == _OK for each in codes)
    known = all(draft.qualified(each).startswith("RTC.") for each in codes)
    if method.returns is None and (is_quiet or known):
        falls_through = not isinstance(method.body[-1], ast.Return)
        code = draft.native("ReturnCode") if not is_quiet else ""
        result = f"{code} | None" if code and falls_through else code or "None"
        if not method.args.args:
            return
        end = draft.source.span(method.args.args[-1])[1]
        draft.source.insert_after(end, b")", f" -> {result}")


def _write_context(
    draft: ModuleDraft, method: ast.FunctionDef, argument: ast.arg, native: str
) -> None:
    if native in ("on_initialize", "on_finalize"):
        _drop_argument(draft, method, argument)
        return
    draft.source.replace(argument, "context: str")
    for node in ast.walk(method):
        if isinstance(node, ast.Name) and node.id == argument.arg:
            draft.source.replace(node, "context")
            parent = draft.source.parent(node)
            is_passed = isinstance(parent, ast.Call) and (
                draft.qualified(parent.func) in ("print", "str")
                or is_call_of_method(parent, *CALLBACKS)
            )
            if not is_passed and not draft.source.is_removed(node):
                draft.mark(node, "the id of a context is a text here, not a number")


def _kept(draft: ModuleDraft, method: ast.FunctionDef | None) -> list[ast.stmt]:
    """Return the statements of a method that do something."""
    if method is None:
        return []
    body = method.body[1:] if ast.get_docstring(method, clean=False) is not None else method.body
    return [
        each
        for each in body
        if not draft.source.is_removed(each)
        and not isinstance(each, ast.Pass)
        and not (isinstance(each, ast.Return) and each.value is None)
    ]


def _write_setup(draft: ModuleDraft, component: OldComponent) -> None:
    """Write what is left of the constructor and of onInitialize as one callback."""
    source = draft.source
    by_name = {each.name: each for each in component.methods}
    made, prepared = by_name.get("__init__"), by_name.get("onInitialize")
    if made is not None and len(made.args.args) > 2:
        draft.mark(made, "the constructor of a component takes no arguments of its own")
    kept = _kept(draft, made)
    if made is not None and kept and not _kept(draft, prepared):
        source.rename_function(made, "on_initialize")
        end = source.span(made.args.args[-1])[1]
        source.insert_after(end, b")", " -> None")
        for argument in made.args.args[1:]:
            _drop_argument(draft, made, argument)
        if isinstance(made.body[-1], ast.Return) and made.body[-1].value is None:
            source.remove(made.body[-1])
    elif made is not None:
        if kept and prepared is not None:
            body = _without_return(source.body_text(made))
            shift = len(source.indent(prepared.body[0])) - len(source.indent(made.body[0]))
            source.insert_text(next(iter(_kept(draft, prepared))), _shifted(body, shift))
        source.remove(made)
    for method in component.methods:
        if method.name in CALLBACKS and not _kept(draft, method) and not source.is_removed(method):
            source.remove(method)
    source.settle()


def _drop_argument(draft: ModuleDraft, method: ast.FunctionDef, argument: ast.arg) -> None:
    begin = draft.source.span(method.args.args[0])[1]
    draft.source.replace_span(begin, draft.source.span(argument)[1], "")
    for node in ast.walk(method):
        is_used = isinstance(node, ast.Name) and node.id == argument.arg
        if is_used and not draft.source.is_removed(node):
            draft.mark(node, f"a native component has no {argument.arg} here")


def _shifted(text: str, columns: int) -> str:
    """Return lines further to the right, or to the left as far as they can go."""
    if columns >= 0:
        return textwrap.indent(text, " " * columns)
    return re.sub(rf"(?m)^ {{1,{-columns}}}", "", text)


def _without_return(body: str) -> str:
    return re.sub(r"\n[ ]*return[ ]*\n*\Z", "\n", body)


def _write_head(draft: ModuleDraft, component: OldComponent, docs: dict[str, str]) -> None:
    """Write the head of the class: docstring, identity, ports, parameters."""
    source, node = draft.source, component.node
    assert isinstance(node, ast.ClassDef)
    for base in node.bases:
        if draft.qualified(base) == _BASE:
            source.replace(base, draft.native("Component"))
    blocks = [
        _docstring(component),
        _identity(component),
        [line for each in component.ports.values() for line in _port_lines(draft, each, docs)],
        [
            line
            for each in [*component.parameters.values(), *component.unbound]
            for line in _parameter_lines(draft, each, docs)
        ],
    ]
    indent = source.indent(node.body[0])
    lines = [
        line for block in blocks if block for line in (*(f"{indent}{each}" for each in block), "")
    ]
    first = node.body[0]
    if isinstance(first, ast.Expr) and text_of(first.value) is not None:
        source.remove(first)
    if not lines and all(source.is_removed(each) for each in node.body):
        lines = [f"{indent}pass"]
    source.settle()
    anchor = node.bases[-1] if node.bases else node
    source.insert_below(anchor, "".join(f"{each}\n" for each in lines))


def _docstring(component: OldComponent) -> list[str]:
    text = component.spec.get("description", "").strip()
    if not text:
        return []
    quoted = text.replace("\\", "\\\\").replace('"""', '\\"""')
    return [f'"""{quoted}{" " if quoted.endswith(chr(34)) else ""}"""']


def _identity(component: OldComponent) -> list[str]:
    spec = component.spec
    name = spec.get("type_name") or spec.get("implementation_id", "")
    texts = {} if name in ("", component.node.name) else {"type_name": name}
    texts |= {key: spec[key] for key in ("vendor", "category", "version") if spec.get(key)}
    lines = [f"{key} = {_quoted(text)}" for key, text in texts.items()]
    kind = spec.get("exec_cxt.periodic.type", "")
    if kind in ("EventDrivenExecutionContext", "ExtTrigExecutionContext"):
        lines.append(f"execution_type = {_quoted(kind)}")
    rate = spec.get("exec_cxt.periodic.rate", "")
    return [*lines, f"rate = {float(rate)!r}"] if re.fullmatch(r"[0-9.]+", rate) else lines


def _quoted(text: str) -> str:
    return f'"{text}"' if text.isprintable() and not set(text) & {'"', "\\"} else repr(text)


def _port_lines(draft: ModuleDraft, port: OldPort, docs: dict[str, str]) -> list[str]:
    arguments = [draft.data_name(port.cls)]
    if port.native.rstrip("_") != port.name:
        arguments.append(_quoted(port.name))
    doc, unit = _read_doc(docs.get(port.attribute, ""))
    text = port.doc or (f"{doc} [{unit}]".strip() if unit else doc)
    named = {"doc": _quoted(text)} if text else {}
    if port.properties:
        pairs = (f"{_quoted(key)}: {_quoted(value)}" for key, value in port.properties.items())
        named["properties"] = f"{{{', '.join(pairs)}}}"
    return _declared(port.native, draft.native(port.kind), arguments, named)


def _parameter_lines(
    draft: ModuleDraft, parameter: OldParameter, docs: dict[str, str]
) -> list[str]:
    extras = dict(parameter.extras)
    if parameter.native.rstrip("_") != parameter.name:
        extras["name"] = _quoted(parameter.name)
    doc, unit = _read_doc(docs.get(parameter.attribute, ""))
    extras |= {"doc": _quoted(doc)} if doc and "doc" not in extras else {}
    extras |= {"unit": _quoted(unit)} if unit else {}
    extras = {key: _double(text) for key, text in extras.items()}
    return _declared(
        parameter.native, draft.native("Parameter"), [_double(parameter.default)], extras
    )


def _double(literal: str) -> str:
    """Return a literal with double quotes, as the rest of a native component has them."""
    is_text = literal.startswith("'") and not set(literal) & {'"', "\\"}
    return f'"{literal[1:-1]}"' if is_text else literal


def _declared(name: str, kind: str, arguments: list[str], named: dict[str, str]) -> list[str]:
    parts = [*arguments, *(f"{key}={text}" for key, text in named.items())]
    line = f"{name} = {kind}({', '.join(parts)})"
    if len(line) <= _WIDE - 4:
        return [line]
    return [f"{name} = {kind}(", *(f"    {each}," for each in parts), ")"]


_FACT = re.compile(
    r"\s*-\s*(Name|Type|Number|DefaultValue|Unit|Constraint|Range|Semantics|Frequency|"
    r"Operation Cycle)\s*:\s*(.*)"
)


def _read_doc(text: str) -> tuple[str, str]:
    """Return what a text of RTC Builder says about a port or parameter, and its unit."""
    words, unit, is_fact = [], "", False
    for line in text.splitlines():
        fact = _FACT.match(line)
        if fact is not None:
            is_fact = True
            unit = fact[2].strip() if fact[1] == "Unit" else unit
        elif line.strip() and not is_fact:
            words.append(line.strip())
    return " ".join(words), unit
