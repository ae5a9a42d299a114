"""``rtexit``: finalise a component and end it, or a slave with all that it holds."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from rtkit.cli.shared.app import App, check_at_most_one
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, flag
from rtkit.errors import Malformed

if TYPE_CHECKING:
    from rtkit.deployment.actions import Delete, EndSlave
    from rtkit.rtc.names import Path
    from rtkit.tree.view import TreeNode

_LADDER_S = 6.0
"""Time-out of asking, TERM and KILL together [s]."""


@command(
    "rtexit",
    examples=(
        ("rtexit /localhost/Robot0.rtc", "End a component; its name goes with it."),
        ("rtexit --force /localhost/Robot0.rtc", "End it though it hangs, with its slave."),
        ("rtexit /localhost/manager.mgr/arm.mgr", "End a slave with all that it holds."),
    ),
    arguments=("component|slave",),
)
def main(
    app: App,
    is_forced: bool = flag("--force", "End the slave that holds it, if need be."),
    paths: tuple[str, ...] = arguments("COMPONENT"),
) -> None:
    """Finalise a component and end it.

    Its connections and names go with it. Returns when it has ended. A slave, MANAGER.mgr/SLAVE.mgr,
    ends with all components in it. A dead component that its policy would bring back stays away.

    A component of which a callback does not come back cannot end; the request stays queued until
    it does. With --force its slave is ended in that case, first asked (TERM), then killed, and
    what else was in it is told and shown as zombies. A slave is ended by force at once. The
    manager's own process is never ended so: rtmgr stop does that.
    """
    if not paths:
        raise Malformed("No component specified.")
    check_at_most_one(paths, "component")
    action = app.node(partial(_action, is_forced), app.path(paths[0]))
    (result,) = app.tree.apply([action], timeout_s=app.timeout_s + _LADDER_S * is_forced)
    result.raise_for_error()
    if result.value:
        app.fail(f"ended with its slave: {result.value.replace(',', ', ')}")
    if result.note:
        app.fail(f"note: {result.note}")


def _action(is_forced: bool, root: TreeNode, path: Path, hostname: str) -> Delete | EndSlave:
    from rtkit.deployment.actions import Delete, EndSlave
    from rtkit.tree.resolve import find, supervised

    node = find(root, path, hostname)
    if node is not None and node.is_slave and path.port is None:
        return EndSlave(node.process, is_forced)
    return Delete(supervised(root, path, hostname).instance, is_forced)
