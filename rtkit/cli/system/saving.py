"""Saves plans in files, and prepares to carry them out unless something has changed."""

from __future__ import annotations

import base64
import os
import time
import zlib
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

import click
from click.core import ParameterSource

from rtkit.cli.shared.app import App
from rtkit.cli.system import planning
from rtkit.cli.system.document import is_saved_plan, parse_document
from rtkit.errors import InvalidDocument, Malformed, Refused, UsageProblem

if TYPE_CHECKING:
    from rtkit.cli.system.document import SystemDocument
    from rtkit.deployment.facts import Snapshot
    from rtkit.deployment.goal import DeploymentGoal
    from rtkit.deployment.planning.deployment_plan import DeploymentPlan
    from rtkit.deployment.planning.model import Model
    from rtkit.deployment.planning.saved import SavedPlan
    from rtkit.deployment.system import WantedSystem
    from rtkit.tree.plan_locks import PlanLocks

_MOST_PROFILE = 1 << 26


def save(
    output: str, document: SystemDocument, prepared: planning.Prepared, options: dict[str, Any]
) -> None:
    """Write a plan, with all its inputs, to a file.

    Raises:
        Refused: There is something else.
        NotFound: It cannot be written.
    """
    from rtkit.cli.shared.atomic import STDOUT, write_output
    from rtkit.deployment.planning.saved import to_text
    from rtkit.profile.read import STDIN, read_bytes

    if output == STDOUT:
        raise UsageProblem("--out needs a file: the plan itself is on stdout")
    if os.path.isfile(output) and os.path.getsize(output) and not is_saved_plan(read_bytes(output)):
        raise Refused(f"{output} is there already, and is no saved plan")
    source = document.source
    about = {
        "profile": source if source == STDIN else os.path.abspath(source),
        "form": document.form,
        "data": base64.b64encode(zlib.compress(document.data)).decode(),
        "options": {**options, "strict": prepared.goal.is_strict},
        "makings": _makings(prepared.goal.system, prepared.snapshot),
    }
    made = time.strftime("%Y-%m-%d %H:%M:%S")
    write_output(to_text(prepared.plan, prepared.goal.ranks, made, about).encode(), output)


def prepare(
    app: App, data: bytes, source: str, *, is_dry: bool, parallel: int, lock: PlanLocks | None
) -> planning.Prepared:
    """Return a saved plan, ready to be carried out.

    Raises:
        InvalidDocument: The file is cut, was changed, or cannot be read.
        Refused: Something has changed since; tells what.
    """
    from rtkit.deployment.planning.saved import from_text

    saved = from_text(data, source)
    origin = _origin(saved, source)
    _check_nothing_else(app, origin.options)
    app.form = origin.form
    app.is_strict |= bool(origin.options.pop("strict", False))
    document = parse_document(app, origin.name, origin.profile)
    try:
        mapped, aim = planning.read_options(origin.options)
        make = partial(_fitting, app, saved, source)
        return planning.prepare(
            app, document, mapped, aim, is_dry=is_dry, parallel=parallel, lock=lock, make=make
        )
    except TypeError as error:
        raise InvalidDocument(f"{source}: the saved plan cannot be read: {error}") from error


class _Origin(NamedTuple):
    """The inputs of a plan."""

    name: str
    form: str | None
    profile: bytes
    options: dict[str, Any]


def _origin(saved: SavedPlan, source: str) -> _Origin:
    about = saved.about
    try:
        packed = base64.b64decode(about["data"])
        return _Origin(
            str(about["profile"]),
            about["form"],
            zlib.decompressobj().decompress(packed, _MOST_PROFILE),
            {str(name): value for name, value in about["options"].items()},
        )
    except (KeyError, TypeError, ValueError, AttributeError, zlib.error) as error:
        raise InvalidDocument(f"{source}: the saved plan cannot be read: {error}") from error


def _fitting(
    app: App, saved: SavedPlan, source: str, goal: DeploymentGoal, snapshot: Snapshot, model: Model
) -> DeploymentPlan:
    """Return the plan if everything is as it was.

    Raises:
        Refused: It is not; what has changed was told.
    """
    from rtkit.deployment.planning.saved import changes

    found = list(changes(saved.model, model))
    was, now = saved.about["makings"], _makings(goal.system, snapshot)
    differing = [each for each in now if was.get(each, now[each]) != now[each]]
    found += [f"component {each} would be made otherwise" for each in differing]
    if found:
        raise _changed(app, saved, source, found, goal, snapshot)
    try:
        return saved.plan(model)
    except Malformed as error:
        raise InvalidDocument(f"{source}: {error}") from error


def _changed(
    app: App,
    saved: SavedPlan,
    source: str,
    found: list[str],
    goal: DeploymentGoal,
    snapshot: Snapshot,
) -> Refused:
    for text in found:
        app.fail(f"changed since: {text}")
    is_so = "; what it leads to is so already" if goal.holds(snapshot) else ""
    hint = "" if is_so else f"; make it anew with: rtplan --out {source} PROFILE"
    return Refused(
        f"{source}: not carried out, as {len(found)} thing{'s have' if len(found) > 1 else ' has'}"
        f" changed since it was made, {saved.made}{is_so or hint}"
    )


def _check_nothing_else(app: App, options: dict[str, Any]) -> None:
    """Refuse options that were settled when the plan was made."""
    context = click.get_current_context()
    given = [
        parameter.opts[-1]
        for parameter in context.command.params
        if parameter.name in options
        and context.get_parameter_source(parameter.name) is ParameterSource.COMMANDLINE
    ]
    given += [f"--{app.form}"] if app.form is not None else []
    if given:
        raise UsageProblem(f"{', '.join(given)}: settled already where the plan is a saved one")


def _makings(system: WantedSystem, snapshot: Snapshot) -> dict[str, list[str]]:
    """Return the inputs of components' creation, by component name."""
    from rtkit.deployment.live_index import LiveIndex

    live = LiveIndex(snapshot, system)
    return {
        each.instance: [live.create_of(each), each.module, each.name] for each in system.components
    }
