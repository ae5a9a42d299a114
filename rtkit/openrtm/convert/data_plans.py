"""Plans for bound data: how a native component keeps what the old one changed in place.

The values of native ports are built once, where they are written. A component that only fills a
value before it writes it keeps nothing; one that fills it step by step in one method keeps the
parts in local variables, one whose parts outlive the method in attributes.
"""

from __future__ import annotations

import ast
from dataclasses import dataclass, field

from rtkit.component.values.type_layout import Layout, StructLayout
from rtkit.openrtm.convert.component_model import BoundData, OldComponent, PartUse, Path
from rtkit.openrtm.convert.draft import ModuleDraft

INLINE, LOCAL, STATE = "inline", "local", "state"
STAMP: Path = ("tm",)
_ROOT: Path = ()


@dataclass
class DataPlan:
    """A way to keep the parts of bound data.

    Attributes:
        leaves: The parts that are used as wholes, each with its native expression.
        way: Built where it is written, local variables, or attributes.
        stores: By target, the statements that set a part.
        runs: By write, the statements right before it that fill the value.
    """

    data: BoundData
    leaves: dict[Path, str] = field(default_factory=dict)
    way: str = STATE
    runs: dict[ast.Call, dict[Path, ast.Assign]] = field(default_factory=dict)
    stores: dict[int, ast.Assign] = field(default_factory=dict)

    def unused_stores(self) -> list[ast.Assign]:
        """Return the statements that set parts nobody looks at or writes."""
        if self.way != LOCAL or self.data.writes:
            return []
        found = []
        for leaf in self.leaves:
            used = [each for each in self.data.accesses if self.leaf_of(each.path) == leaf]
            if all(each.how == "store" and each.path == leaf for each in used):
                found += [
                    self.stores[id(each.node)] for each in used if id(each.node) in self.stores
                ]
        return found

    def leaf_of(self, path: Path) -> Path:
        """Return the part that a path leads to, or into."""
        return next(path[:n] for n in range(len(path) + 1) if path[:n] in self.leaves)


def plan_of(draft: ModuleDraft, component: OldComponent, data: BoundData) -> DataPlan:
    """Return the plan for bound data; says to the draft what needs a hand."""
    plan = DataPlan(data)
    for path in _in_order({each.path for each in data.accesses}, data.layout):
        if not any(path[:n] in plan.leaves for n in range(len(path))):
            plan.leaves[path] = ""
    if data.rebound and data.writes:
        bare = [call for call, _ in data.writes if not call.args]
        for call in bare:
            draft.mark(
                call,
                "write() sends the value that the port was made with, not the one in its place now",
            )
    _mark_sharing(draft, data)
    plan.runs = {call: _run(draft, plan, call) for call, _ in data.writes}
    for access in data.accesses:
        statement = draft.source.statement(access.node)
        if isinstance(statement, ast.Assign) and statement.targets == [access.node]:
            plan.stores[id(access.node)] = statement
    if _is_inline(plan):
        plan.way = INLINE
    elif not _is_kept_for_nobody(plan) and _is_local(draft, component, plan):
        plan.way = LOCAL
    _name(draft, component, plan)
    return plan


_LOOKERS = ("copy.copy", "copy.deepcopy", "deepcopy", "print", "repr", "str")


def _mark_sharing(draft: ModuleDraft, data: BoundData) -> None:
    """Mark where something else could change a value that is written later."""
    if not data.writes:
        return
    for access in data.accesses:
        if access.path or access.how != "load":
            continue
        outer = draft.source.parent(access.node)
        is_looked_at = isinstance(outer, ast.Compare) or (
            isinstance(outer, ast.Call) and draft.qualified(outer.func) in _LOOKERS
        )
        if not is_looked_at:
            draft.mark(access.node, "what has this value too could change it before it is written")


def _in_order(paths: set[Path], layout: Layout) -> list[Path]:
    """Return paths as the fields of the structure stand, wholes before their parts."""

    def place(path: Path) -> list[int]:
        found, inner = [], layout
        for each in path:
            assert isinstance(inner, StructLayout)
            names = [name for name, _ in inner.fields]
            found.append(names.index(each))
            inner = dict(inner.fields)[each]
        return found

    return sorted(paths, key=place)


def part_of(layout: Layout, path: Path) -> Layout:
    """Return the layout of a part of a value."""
    for each in path:
        assert isinstance(layout, StructLayout)
        layout = dict(layout.fields)[each]
    return layout


def _run(draft: ModuleDraft, plan: DataPlan, call: ast.Call) -> dict[Path, ast.Assign]:
    """Return the statements right before a write that set parts of its value, by part."""
    source = draft.source
    statement = source.statement(call)
    if not (isinstance(statement, ast.Expr) and statement.value is call):
        return {}
    block = source.block(statement)
    found: dict[Path, ast.Assign] = {}
    targets = {id(each.node): each.path for each in plan.data.accesses if each.how == "store"}
    for each in reversed(block[: block.index(statement)]):
        if each in plan.data.stamps:
            continue
        target = (
            each.targets[0] if isinstance(each, ast.Assign) and len(each.targets) == 1 else None
        )
        path = targets.get(id(target))
        if path is None or path in found or path not in plan.leaves:
            break
        assert isinstance(each, ast.Assign)
        found[path] = each
    return found


def _is_inline(plan: DataPlan) -> bool:
    if _ROOT in plan.leaves:
        return False
    used = {id(each.targets[0]) for run in plan.runs.values() for each in run.values()}
    is_filled = all(id(each.node) in used for each in plan.data.accesses)
    return is_filled and all(set(run) == set(plan.leaves) for run in plan.runs.values())


def _is_local(draft: ModuleDraft, component: OldComponent, plan: DataPlan) -> bool:
    """Return whether each method that uses parts sets them before, whatever happened earlier."""
    for method in component.methods:
        inside = [each for each in plan.data.accesses if draft.source.method(each.node) is method]
        writes = [call for call, _ in plan.data.writes if draft.source.method(call) is method]
        wanted = set(plan.leaves) if writes else {plan.leaf_of(each.path) for each in inside}
        for leaf in wanted:
            used = [each for each in inside if plan.leaf_of(each.path) == leaf]
            if not _begins_with_store(draft, leaf, used, writes):
                return False
        if plan.data.stamps and _ROOT in plan.leaves:
            return False
    return True


def _is_kept_for_nobody(plan: DataPlan) -> bool:
    """Return whether parts are set, but neither looked at nor written: a slip of the author."""
    uses = [(each.path, each.how) for each in plan.data.accesses]
    return not plan.data.writes and any(
        all(how == "store" for path, how in uses if plan.leaf_of(path) == leaf)
        for leaf in plan.leaves
        if leaf != _ROOT
    )


def _begins_with_store(
    draft: ModuleDraft, leaf: Path, used: list[PartUse], writes: list[ast.Call]
) -> bool:
    source = draft.source
    nodes = [each.node for each in used] + list(writes)
    blocks = [_chain(draft, each) for each in nodes]
    common = [each for each in blocks[0] if all(_has(each, chain) for chain in blocks)]
    if not common:
        return False
    block = common[0][0]
    for statement in block:
        touching = [n for n in nodes if statement in (n, *source.ancestors(n))]
        if not touching:
            continue
        target = statement.targets[0] if isinstance(statement, ast.Assign) else None
        stores = [each for each in used if each.node is target and each.path == leaf]
        return bool(stores) and len(touching) == 1
    return False


def _chain(draft: ModuleDraft, node: ast.AST) -> list[tuple[list[ast.stmt], ast.stmt]]:
    """Return the blocks around a node, the nearest first, with the statement in each."""
    found = []
    statement = draft.source.statement(node)
    while not isinstance(statement, ast.FunctionDef):
        found.append((draft.source.block(statement), statement))
        parent = draft.source.parent(statement)
        statement = draft.source.statement(parent)
    return found


def _has(
    entry: tuple[list[ast.stmt], ast.stmt], chain: list[tuple[list[ast.stmt], ast.stmt]]
) -> bool:
    return any(block is entry[0] for block, _ in chain)


def _name(draft: ModuleDraft, component: OldComponent, plan: DataPlan) -> None:
    base = plan.data.port_name if plan.data.port_name.isidentifier() else plan.data.attribute
    for leaf in plan.leaves:
        wanted = base if leaf in (_ROOT, ("data",)) else f"{leaf[-1]}"
        if leaf == STAMP:
            wanted = f"{base}_time"
        if plan.way == STATE:
            name = draft.free(f"_{wanted.lstrip('_')}", component.own_names)
            component.own_names.add(name)
            plan.leaves[leaf] = f"self.{name}"
        elif plan.way == LOCAL:
            plan.leaves[leaf] = draft.free_local(wanted.lstrip("_"))
