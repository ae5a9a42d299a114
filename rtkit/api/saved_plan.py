"""Saves plans in files, and prepares to carry them out unless something has changed."""

from __future__ import annotations

import base64
import os
import time
import zlib
from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

from rtkit.api import planning
from rtkit.api.system_profiles import is_saved_plan, parse_document, with_hosts
from rtkit.errors import InvalidDocument, Malformed, Refused

if TYPE_CHECKING:
    from rtkit.api.session import Session
    from rtkit.api.system_profiles import SystemProfile
    from rtkit.deployment.facts import Snapshot
    from rtkit.deployment.goal import DeploymentGoal
    from rtkit.deployment.planning.deployment_plan import DeploymentPlan
    from rtkit.deployment.planning.model import Model
    from rtkit.deployment.planning.saved import SavedPlan
    from rtkit.tree.plan_locks import PlanLocks

_MOST_PROFILE = 1 << 26


def save(
    output: str, document: SystemProfile, prepared: planning.Prepared, options: dict[str, Any]
) -> None:
    """Write a plan, with all its inputs, to a file.

    Raises:
        Refused: There is something else.
        NotFound: It cannot be written.
    """
    from rtkit.deployment.planning.saved import to_text
    from rtkit.link.atomic import write_output
    from rtkit.profile.read import STDIN, read_bytes

    if os.path.isfile(output) and os.path.getsize(output) and not is_saved_plan(read_bytes(output)):
        raise Refused(f"{output} is there already, and is no saved plan")
    source = document.source
    about = {
        "profile": source if source == STDIN else os.path.abspath(source),
        "form": document.form,
        "data": base64.b64encode(zlib.compress(document.data)).decode(),
        "options": {**options, "strict": prepared.goal.is_strict},
        "makings": _makings(prepared.goal, prepared.snapshot),
    }
    made = time.strftime("%Y-%m-%d %H:%M:%S")
    write_output(to_text(prepared.plan, prepared.goal.ranks, made, about).encode(), output)


class SavedInputs(NamedTuple):
    """A saved plan, and the inputs that it was made from.

    Attributes:
        source: Names the file of the plan.
        name: Names the profile.
        options: By which the plan was made.
    """

    saved: SavedPlan
    source: str
    name: str
    form: str | None
    profile: bytes
    options: dict[str, Any]


def opened(data: bytes, source: str) -> SavedInputs:
    """Read a saved plan.

    Raises:
        InvalidDocument: The file is cut, was changed, or cannot be read.
    """
    from rtkit.deployment.planning.saved import from_text

    saved = from_text(data, source)
    about = saved.about
    try:
        packed = base64.b64decode(about["data"])
        return SavedInputs(
            saved,
            source,
            str(about["profile"]),
            about["form"],
            zlib.decompressobj().decompress(packed, _MOST_PROFILE),
            {str(name): value for name, value in about["options"].items()},
        )
    except (KeyError, TypeError, ValueError, AttributeError, zlib.error) as error:
        raise InvalidDocument(f"{source}: the saved plan cannot be read: {error}") from error


def prepare(
    session: Session, inputs: SavedInputs, *, is_dry: bool, parallel: int, lock: PlanLocks | None
) -> planning.Prepared:
    """Return a saved plan, ready to be carried out.

    Raises:
        InvalidDocument: The file cannot be read.
        Refused: Something has changed since; tells what.
    """
    options = {**inputs.options}
    session.is_strict |= bool(options.pop("strict", False))
    document = parse_document(session, inputs.name, inputs.profile, inputs.form)
    try:
        mapped, aim = planning.read_options(options)
        make = partial(_fitting, session, inputs.saved, inputs.source)
        document = with_hosts(document, mapped)
        return planning.prepare(
            session, document, aim, is_dry=is_dry, parallel=parallel, lock=lock, make=make
        )
    except TypeError as error:
        why = f"{inputs.source}: the saved plan cannot be read: {error}"
        raise InvalidDocument(why) from error


def _fitting(
    session: Session,
    saved: SavedPlan,
    source: str,
    goal: DeploymentGoal,
    snapshot: Snapshot,
    model: Model,
) -> DeploymentPlan:
    """Return the plan if everything is as it was.

    Raises:
        Refused: It is not; what has changed was told.
    """
    from rtkit.deployment.planning.saved import changes

    found = list(changes(saved.model, model))
    was, now = saved.about["makings"], _makings(goal, snapshot)
    differing = [each for each in now if was.get(each, now[each]) != now[each]]
    found += [f"component {each} would be made otherwise" for each in differing]
    if found:
        raise _changed(session, saved, source, found, goal, snapshot)
    try:
        return saved.plan(model)
    except Malformed as error:
        raise InvalidDocument(f"{source}: {error}") from error


def _changed(
    session: Session,
    saved: SavedPlan,
    source: str,
    found: list[str],
    goal: DeploymentGoal,
    snapshot: Snapshot,
) -> Refused:
    for text in found:
        session.fail(f"changed since: {text}")
    is_so = "; what it leads to is so already" if goal.holds(snapshot) else ""
    hint = "" if is_so else f"; make it anew with: rtplan --out {source} PROFILE"
    return Refused(
        f"{source}: not carried out, as {len(found)} thing{'s have' if len(found) > 1 else ' has'}"
        f" changed since it was made, {saved.made}{is_so or hint}"
    )


def _makings(goal: DeploymentGoal, snapshot: Snapshot) -> dict[str, list[str]]:
    """Return the inputs of components' creation, by component name."""
    from rtkit.deployment.live_index import LiveIndex

    live, packages = LiveIndex(snapshot, goal.system), goal.packages

    def wheels(instance: str) -> Iterator[str]:
        text = packages.of.get(instance, "")
        for package, digests in packages.digests.items():
            if package.partition("/")[2] == text:
                yield from (f"{file} {digest}" for file, digest in sorted(digests.items()))

    return {
        each.instance: [live.create_of(each), each.module, each.name, *wheels(each.instance)]
        for each in goal.system.components
    }
