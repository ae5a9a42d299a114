"""Steps of ``rtmgr`` at a manager: read from the command line, then run in order."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, NamedTuple

from rtkit.cli.components.conf import warn_of_vain
from rtkit.cli.shared import json_records, terminal
from rtkit.errors import RtkitError, UsageProblem, from_kind
from rtkit.rtc.create import parse_create
from rtkit.rtc.names import COMPONENT_SUFFIX, MANAGER_SUFFIX

if TYPE_CHECKING:
    from rtkit.cli.shared.app import App
    from rtkit.deployment.actions import Action, Create
    from rtkit.deployment.facts import Snapshot
    from rtkit.tree.view import TreeNode

_FAILED = {
    "load": "Failed to load module",
    "unload": "Failed to unload module",
    "create": "Failed to create component",
    "delete": "Failed to delete component",
    "configure": "Failed to set configuration",
    "fork": "Failed to fork",
}
_ACTIONS = ("load", "unload", "create", "delete")
"""Kinds whose module is only imported when one is asked for: it is not needed for looking."""


class ManagerStep(NamedTuple):
    """One thing to do: its kind, what the user typed, and the action it is, if it is one."""

    kind: str
    typed: str
    action: Action | None = None

    @property
    def is_action(self) -> bool:
        """Return whether it travels in a batch."""
        return self.action is not None

    def failure(self, kind: str, why: str) -> RtkitError:
        """Return the error that tells that it failed, and why."""
        return from_kind(kind, f"{_FAILED[self.kind]}: {self.typed} ({why})")


def read_step(kind: str, typed: str) -> ManagerStep:
    """Read one option of the command line.

    Raises:
        UsageProblem: A part of it is missing.
        Malformed: It cannot be read.
    """
    if kind not in _ACTIONS:
        if kind == "configure" and not typed.partition("=")[1]:
            raise UsageProblem(f"Bad property format: {typed} (it is KEY=VALUE)")
        return ManagerStep(kind, typed)
    from rtkit.deployment.actions import Delete, Load, Unload

    if kind == "load":
        path, init = _split_init(typed)
        return ManagerStep(kind, typed, Load(_module_path(path), init))
    if kind == "unload":
        return ManagerStep(kind, typed, Unload(_module_path(typed)))
    if kind == "create":
        return ManagerStep(kind, typed, _create(typed))
    return ManagerStep(kind, typed, Delete(typed))


def _split_init(typed: str) -> tuple[str, str]:
    path, colon, init = typed.rpartition(":")
    if not colon or not path or not init or "/" in init:
        raise UsageProblem("No initialisation function specified.")
    return path, init


def _module_path(typed: str) -> str:
    return os.path.abspath(typed) if typed.startswith(("./", "../")) else typed


def _create(typed: str) -> Create:
    from rtkit.deployment.actions import Create

    try:
        identity, question, options = typed.partition("?")
        if not (identity.endswith(".xml") or ("/" in identity and os.path.isfile(identity))):
            return Create(str(parse_create(typed)))
        from rtkit.cli.managers.stand_in import read_pattern

        pattern = read_pattern(identity)
        create = parse_create(f"stand-in{question}{options}")
        return Create(str(create), pattern=pattern)
    except RtkitError as error:
        step = ManagerStep("create", typed)
        raise step.failure(error.kind, str(error)) from error


class StepRunner:
    """Does steps at one manager, in order; consecutive actions travel as one batch."""

    def __init__(self, app: App, node: TreeNode, is_printing: bool, is_json: bool) -> None:
        self._app = app
        self._node = node
        self._is_printing = is_printing
        self._is_json = is_json

    def run(self, steps: Sequence[ManagerStep]) -> None:
        """Do all steps, or those before the first that fails.

        Raises:
            RtkitError: A step failed; names it.
        """
        for is_batch, group in groupby(steps, key=lambda step: step.is_action):
            if is_batch:
                self._perform(list(group))
            else:
                for step in group:
                    self._ask(step)

    def _perform(self, steps: Sequence[ManagerStep]) -> None:
        from rtkit.deployment.actions import strict

        actions = [self._placed(step.action) for step in steps if step.action]
        if self._app.is_strict:
            actions = list(map(strict, actions))
        results = self._app.tree.apply(actions)
        for step, result in zip(steps, results, strict=False):
            self._app.verbose(
                f"{step.kind} {step.typed}: {result.value if result.ok else 'failed'}"
            )
            for note in filter(None, (result.note, result.left_out)):
                self._app.fail(f"note: {note}")
        made = [
            result.value
            for step, result in zip(steps, results, strict=False)
            if step.kind == "create" and result.ok
        ]
        if made and self._is_printing:
            terminal.write(self._paths(made))
        last = results[-1]
        if not last.ok:
            raise steps[len(results) - 1].failure(last.kind, last.why)

    def _placed(self, action: Action) -> Action:
        """Return an action as it is meant at a slave: within that slave."""
        from rtkit.deployment.actions import Create, Delete

        if isinstance(action, Delete) and self._node.is_slave:
            return Delete(action.instance, slave=self._node.process)
        if not isinstance(action, Create) or not self._node.is_slave:
            return action
        create = parse_create(action.create)
        if create.place:
            return action
        return Create(
            str(create.with_options(manager_name=self._node.process)), action.names, action.pattern
        )

    def _paths(self, instances: Sequence[str]) -> list[str]:
        names = {row.instance: row.names for row in self._app.tree.listing().rows}
        below = self._node.path
        return [
            terminal.printable(
                self._app.shown(names.get(instance, ())) or f"{below}/{instance}{COMPONENT_SUFFIX}"
            )
            for instance in instances
        ]

    def _ask(self, step: ManagerStep) -> None:
        if step.kind in ("configure", "fork"):
            self._set(step)
            return
        tree = self._app.tree
        snapshot = tree.snapshot() if step.kind == "components" else tree.part([])
        if step.kind == "properties":
            self._show_properties(snapshot)
        elif step.kind == "modules":
            self._show_modules(snapshot)
        else:
            self._show(self._components(snapshot))

    def _set(self, step: ManagerStep) -> None:
        key, _, value = step.typed.partition("=") if step.kind == "configure" else ("fork", "", "")
        if step.kind == "configure":
            warn_of_vain(self._app, {key: value})
        try:
            done = self._app.tree.set(key, value)
        except RtkitError as error:
            raise step.failure(error.kind, str(error)) from error
        if step.kind == "fork" and self._is_printing:
            path = self._node.path
            above = path.rpartition("/")[0] if self._node.is_slave else path
            terminal.write([terminal.printable(f"{above}/{done}{MANAGER_SUFFIX}")])

    def _show_modules(self, snapshot: Snapshot) -> None:
        """List the types of modules that are loaded or could be; the rest with its reason."""
        from rtkit.cli.shared.offers import offers

        files, problems = offers(self._app.tree, snapshot)
        if self._is_json:
            known = [{"type": t, "module": m or None, "problem": None} for t, m in files.items()]
            bad = [{"type": None, "module": m, "problem": why} for m, why in problems]
            terminal.write(json_records.lines("component-type", [*known, *bad]))
            return
        self._show({"type": name} for name in files)
        for name, why in problems:
            self._app.fail(f"module cannot be read: {name} ({why})")

    def _components(self, snapshot: Snapshot) -> Iterator[dict[str, str]]:
        for facts in snapshot.components:
            if self._node.is_slave and facts.process != self._node.process:
                continue
            yield {
                "instance": facts.instance,
                "type": facts.type.full_id,
                "name": self._seen_here(facts.names, snapshot.host),
                "host": snapshot.host,
                "manager": facts.process,
            }

    def _seen_here(self, names: Sequence[str], host: str) -> str:
        """Return the first name as the tree here has it: another `host` calls itself localhost."""
        path = self._app.shown(names)
        return path[1:] if path.startswith(f"/{host}/") else next(iter(names), "")

    def _show(self, rows: Iterator[dict[str, str]]) -> None:
        table = list(rows)
        if self._is_json:
            terminal.write(json_records.lines("instance", table))
            return
        cells = [[terminal.printable(text or "-") for text in row.values()] for row in table]
        widths = [max(map(terminal.display_width, column)) for column in zip(*cells, strict=True)]
        terminal.write("  ".join(map(terminal.padded, line, widths)).rstrip() for line in cells)

    def _show_properties(self, snapshot: Snapshot) -> None:
        rows = sorted(snapshot.properties.items())
        if self._is_json:
            terminal.write([json_records.line("properties", {"properties": dict(rows)})])
        else:
            terminal.write(terminal.pairs([(f"{key}:", value) for key, value in rows], ""))
