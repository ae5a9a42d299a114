"""Writes what is around the classes: init function, what runs by hand, imports."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from rtkit.openrtm.convert.class_writing import write_values
from rtkit.openrtm.convert.component_model import OldComponent
from rtkit.openrtm.convert.draft import API, FOREIGN, MARK, HandWork, ModuleDraft
from rtkit.openrtm.convert.expressions import write_name
from rtkit.openrtm.convert.reading import is_call_of_method

_STARTING = (
    "activateManager", "activate_component", "createComponent", "getPOA", "get_owned_contexts",
    "init", "instance", "registerFactory", "runManager", "servant_to_reference",
    "setModuleInitProc", "_default_POA", "_narrow", "shutdown",
)  # fmt: skip
"""Methods by which an old module starts itself: `rtkit.run` does all that."""


def write_module(draft: ModuleDraft, components: list[OldComponent]) -> None:
    """Write the init function of a module and its last lines."""
    if not components:
        return
    functions = {
        each.name: each for each in draft.source.tree.body if isinstance(each, ast.FunctionDef)
    }
    starting = _starting(draft, functions)
    chosen, name = _init_function(functions, starting, components)
    lines = _init_lines(draft, name, components)
    runs = _run_lines(draft, starting, components)
    is_run = False
    for statement in draft.source.tree.body:
        if statement is chosen:
            draft.source.replace(statement, "\n".join(lines))
        elif isinstance(statement, ast.FunctionDef) and statement.name in starting:
            draft.source.remove(statement)
        elif _starts(statement, starting):
            draft.source.replace(statement, "\n".join(runs))
            is_run = True
    if not is_run:
        draft.source.insert_below(draft.source.tree.body[-1], "\n\n" + "\n".join(runs) + "\n")


def write_outside(draft: ModuleDraft, components: list[OldComponent]) -> None:
    """Write what is no component: names of the API, and values that functions make and change."""
    classes = {id(each.node) for each in components}
    for statement in draft.source.tree.body:
        if id(statement) in classes or draft.source.is_removed(statement):
            continue
        if isinstance(statement, (ast.FunctionDef, ast.ClassDef)):
            write_values(draft, OldComponent(statement, {}))
        else:
            for node in reversed([*ast.walk(statement)]):
                write_name(draft, node)


def _starting(
    draft: ModuleDraft, functions: dict[str, ast.FunctionDef]
) -> dict[str, ast.FunctionDef]:
    """Return the functions that register or create components, or start a manager."""
    return {
        name: function
        for name, function in functions.items()
        if any(
            is_call_of_method(node, "registerFactory", "createComponent", "setModuleInitProc")
            or draft.call_of(node) == f"{API}.Manager.init"
            for node in ast.walk(function)
        )
    }


def _init_function(
    functions: dict[str, ast.FunctionDef],
    starting: dict[str, ast.FunctionDef],
    components: list[OldComponent],
) -> tuple[ast.FunctionDef | None, str]:
    """Return the function that becomes the init function, and its name."""
    registering = [
        each
        for each in starting.values()
        if any(is_call_of_method(node, "registerFactory") for node in ast.walk(each))
    ]
    pure = [
        each
        for each in registering
        if not any(is_call_of_method(node, "createComponent") for node in ast.walk(each))
    ]
    chosen = next(iter([*pure, *registering]), None)
    is_usual = chosen is not None and chosen in pure and chosen.name.endswith("Init")
    is_usual = is_usual and chosen is not None and chosen.name not in ("MyModuleInit", "ModuleInit")
    name = chosen.name if is_usual and chosen is not None else f"{components[0].node.name}Init"
    return chosen, name


def _init_lines(draft: ModuleDraft, name: str, components: list[OldComponent]) -> list[str]:
    registered = [each for each in components if each.spec] or components
    body = [f"    manager.register_factory({each.node.name})" for each in registered]
    manager = draft.native("Manager")
    return [f"def {name}(manager: {manager}) -> None:", *body]


def _starts(statement: ast.stmt, starting: dict[str, ast.FunctionDef]) -> bool:
    """Return whether a statement at the top of a module starts it."""
    if isinstance(statement, (ast.FunctionDef, ast.ClassDef, ast.Import, ast.ImportFrom)):
        return False
    return any(
        isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in starting
        for node in ast.walk(statement)
    )


def _run_lines(
    draft: ModuleDraft, starting: dict[str, ast.FunctionDef], components: list[OldComponent]
) -> list[str]:
    calls = [node for each in starting.values() for node in ast.walk(each)]
    is_active = any(is_call_of_method(node, "activate_component") for node in calls)
    created = [
        str(node.args[0].value).partition("?")[0]
        for node in calls
        if is_call_of_method(node, "createComponent")
        and node.args
        and isinstance(node.args[0], ast.Constant)
    ]
    names = {each.spec.get("implementation_id", ""): each.node.name for each in components}
    name = next((names[each] for each in created if each in names), components[0].node.name)
    for each in components:
        if not each.spec:
            draft.mark(each.node, "its specification is computed, or no function registers it")
    lines = []
    for function in starting.values():
        for statement in _others(function.body, set(starting)):
            what = draft.source.text(statement).partition("\n")[0]
            reason = f"{function.name}() did more than start the component: {what}"
            draft.marks.append(HandWork(statement.lineno, reason))
            lines.append(f"    {MARK}{reason}")
    arguments = f"{name}, activate=True" if is_active else name
    return ['if __name__ == "__main__":', *lines, f"    rtkit.run({arguments})"]


def _others(body: list[ast.stmt], starting: set[str]) -> Iterator[ast.stmt]:
    """Yield the statements of a function that are not only for the start of a component."""
    known = {"manager", "mgr"}
    for statement in body:
        nodes = list(ast.walk(statement))
        is_start = any(
            is_call_of_method(node, *_STARTING)
            or (
                isinstance(node, ast.Call)
                and isinstance(node.func, ast.Name)
                and node.func.id in starting
            )
            or (isinstance(node, ast.Attribute) and node.attr == "argv")
            for node in nodes
        )
        names = {node.id for node in nodes if isinstance(node, ast.Name)}
        stores = {
            node.id
            for node in nodes
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
        }
        is_profile = "Properties" in {getattr(n, "attr", getattr(n, "id", "")) for n in nodes}
        is_quiet = isinstance(statement, (ast.Pass, ast.Return, ast.Global)) or (
            isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)
        )
        prints = isinstance(statement, ast.Expr) and "print" in names
        if is_start or is_profile or is_quiet or prints or (stores and names & known):
            known |= stores
        else:
            yield statement


def is_foreign_import(draft: ModuleDraft, statement: ast.stmt) -> bool:
    """Return whether a statement imports only what native components do not have."""
    if isinstance(statement, ast.Import):
        return all(each.name.partition(".")[0] in FOREIGN | draft.stubs for each in statement.names)
    if isinstance(statement, ast.ImportFrom):
        root = (statement.module or "").partition(".")[0]
        is_future = root == "__future__" and statement.names[0].name != "annotations"
        return root in FOREIGN | draft.stubs or is_future
    return False
