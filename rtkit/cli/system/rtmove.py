"""``rtmove``: move a component to another slave or manager."""

from __future__ import annotations

from rtkit.cli.shared import terminal
from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, flag
from rtkit.cli.system import shared


@command(
    "rtmove",
    examples=(
        ("rtmove -n /localhost/Motor0.rtc /localhost/m2.mgr", "Show the steps and their costs."),
        (
            "rtmove /localhost/Motor0.rtc /localhost/manager.mgr/arm.mgr",
            "Move it to slave arm, which is made if it is not there.",
        ),
    ),
    json=("plan", "step"),
    arguments=("component", "manager|slave"),
)
def main(
    app: App,
    dry_run: bool = flag("-n --dry-run", "Print what would be done, and do nothing."),
    wait_s: float = shared.WAIT,
    is_json: bool = shared.PLAN_JSON,
    paths: tuple[str, ...] = arguments("COMPONENT TARGET"),
) -> None:
    """Move a component to another slave, manager or linked host.

    TARGET is a manager, /localhost/m2.mgr, for its own process, or a slave of one,
    /localhost/m2.mgr/arm.mgr; that of a linked host is /robot1/manager.mgr. The component ends here
    and is made there, with the configuration, rates, policy, names and connections that it has, and
    is Active again if it was. There is never more than one of its name. Its own variables begin
    anew.

    Values on the way are lost only if the policy of their connection says so: what is written to it
    meanwhile is kept by the ports that write, in a buffer of that policy and length; what has
    arrived it reads before it ends, for which it has 2 s; what it wrote arrives first. Pull
    connections and components that are not Active keep nothing that was not read.

    Whether it can be made there is asked before anything ends. When a step fails it is made here
    again. Where the command or a manager was killed, the same command goes on: until all is done,
    a file beside the logs keeps what the component was like.
    """
    from rtkit.api import moving
    from rtkit.deployment.planning.rendering import as_plain, lines

    shared.watch(app, is_json=is_json)
    if len(paths) != 2:
        raise WrongArguments("needs a component and where it is to go")
    path, target = app.path(paths[0]), app.beside(paths[1])
    lock = None if dry_run else shared.locks(app, paths, wait_s)
    move = moving.prepare(app, path, target, lock=lock)
    if app.watch is not None and (dry_run or not move.plan.moves):
        app.watch.plan(as_plain(move.plan, move.goal.costs))
    elif dry_run:
        terminal.write(map(terminal.printable, lines(move.plan, move.goal.costs)))
    if dry_run:
        return
    moving.carry_out(app, move)
    if not move.plan.moves:
        app.verbose(f"{move.record.facts.instance} is at {move.record.place} already")
