"""Requests a state transition of many components: ``rtact``, ``rtdeact``, ``rtreset``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import Main, command
from rtkit.cli.shared.options import arguments, flag, option
from rtkit.errors import Malformed, Partial, RtkitError, UsageProblem, from_kind
from rtkit.rtc.enums import Transition

if TYPE_CHECKING:
    from rtkit.deployment.actions import ChangeState, Result
    from rtkit.rtc.names import Path

ALL = "all"
_Asked = tuple["Path", "ChangeState"]


def state_command(
    name: str, transition: Transition, summary: str, more: str = "", **declared: Any
) -> Main:
    """Return the command that asks execution contexts for `transition`."""

    @command(name, help=_help(summary, more), **declared)
    def main(
        app: App,
        context: str = option(
            "-e --exec_context EC",
            "Execution context: its number (own ones first, then those taken part in; default 0),"
            " or all.",
            default="0",
        ),
        no_wait: bool = flag("--no-wait", "Do not wait until the transition is done."),
        paths: tuple[str, ...] = arguments("COMPONENT..."),
    ) -> None:
        change(app, paths, transition, context, wait=not no_wait)

    return main


def _help(summary: str, more: str) -> str:
    return (
        f"{summary}\n\nWaits until every component named is there (--timeout bounds it) and prints"
        " nothing; one that is there already is left as it is. All paths are checked before"
        f" anything changes.{more}"
    )


def change(
    app: App, typed: Sequence[str], transition: Transition, context: str, *, wait: bool
) -> None:
    """Ask for `transition` in a context of each component, all in one batch.

    Raises:
        RtkitError: A component does not exist, or at least one of them refused.
    """
    from rtkit.tree.resolve import check_component_syntax

    if not typed:
        raise Malformed("No components specified.")
    paths = [app.path(each) for each in typed]
    for path in paths:
        check_component_syntax(path)
    asked = _asked(app, paths, transition, _index(context), wait)
    results = app.tree.apply([action for _, action in asked], is_ordered=False)
    for (path, _), result in zip(asked, results, strict=True):
        if result.note:
            app.fail(f"note: {result.note}: {path.typed}")
    failures = [
        (path.typed, error)
        for (path, action), result in zip(asked, results, strict=True)
        if (error := _error(path, action, result)) is not None
    ]
    if len(failures) == 1 == len(asked):
        raise failures[0][1]
    if failures:
        done = len(asked) - len(failures)
        raise Partial(f"{len(failures)} of {done + len(failures)} refused", failures)


def _index(context: str) -> int | None:
    """Return the number of the context, None for all of them."""
    if context == ALL:
        return None
    try:
        return int(context)
    except ValueError:
        hint = "give its number, or all"
        raise UsageProblem(f"no execution context: {context} ({hint})") from None


def _asked(
    app: App, paths: Sequence[Path], transition: Transition, index: int | None, wait: bool
) -> list[_Asked]:
    from rtkit.deployment.actions import ChangeState
    from rtkit.tree.resolve import component, nodes_at, supervised

    # The short listing only has the first context.
    find = component if transition is Transition.ACTIVATE else supervised
    nodes = nodes_at(app.tree, paths, find)
    snapshot = app.tree.part([node.instance for node in nodes]) if index != 0 else None
    asked: list[_Asked] = []
    for path, node in zip(paths, nodes, strict=True):
        instance = node.instance
        facts = snapshot.component(instance) if snapshot is not None else None
        contexts = [node.row.context] if node.row is not None and node.row.context else []
        if facts is not None:
            contexts = [context.id for context in facts.contexts]
        chosen = contexts if index is None else contexts[index : index + 1] if index >= 0 else []
        if not chosen:
            has = f"{path.typed} has {len(contexts)}"
            raise Malformed(f"Bad execution context index: {index or 0} ({has})")
        asked += [(path, ChangeState(instance, id, transition, wait)) for id in chosen]
    return asked


def _error(path: Path, action: ChangeState, result: Result) -> RtkitError | None:
    if result.ok:
        return None
    # The message names the component as the user typed it, not as the manager does.
    why = result.why.removesuffix(f": {action.instance}")
    return from_kind(result.kind, f"{why}: {path.typed}")
