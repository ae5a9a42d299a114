"""``rtmgr``: start, stop, install and command managers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

from rtkit import fault
from rtkit.cli.managers.word_options import WordOptions
from rtkit.cli.shared.app import App, check_at_most_one
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import (
    arguments,
    flag,
    json_flag,
    option,
    several,
    strict_option,
    together,
)
from rtkit.errors import Malformed, Unreachable, UsageProblem

if TYPE_CHECKING:
    from rtkit.cli.managers.steps import ManagerStep
    from rtkit.tree.view import TreeNode

WORDS = ("start", "stop", "restart", "status", "run", "install", "uninstall", "dump", "replay")
_OF_START = "start, run and install"
_ORDER = "rtkit.order"
_FOR_START = "-f, -o, -p, -a, -i, --tls and --allow-faults"


class _InOrder(click.Command):
    """Remembers options with their values in the order of the command line."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        values, _, order = self.make_parser(ctx).parse_args(list(args))
        steps: list[tuple[str, object]] = []
        taken: dict[str, int] = {}
        for parameter in order:
            name = parameter.name or ""
            if name not in _STEPS:
                continue
            index = taken.get(name, 0)
            taken[name] = index + 1
            steps.append((name, values[name][index]))
        ctx.meta[_ORDER] = steps
        return super().parse_args(ctx, args)


_STEPS = {
    "load": several("-l --load PATH:INIT", "Load a module, call its init function."),
    "unload": several("-u --unload PATH", "Forget a module."),
    "create": several("-c --create CREATE", "Create a component, or a stand-in (FILE.xml)."),
    "delete": several("-d --delete NAME", "Finalise and delete a component."),
    "configure": several("-s --setconfig KEY=VALUE", "Set a property of the manager."),
    "fork": flag("--fork", "Start a slave without components.", multiple=True),
    "modules": flag("-m --modules", "List component types that modules offer.", multiple=True),
    "components": flag("-r --rtcs", "List the components.", multiple=True),
    "properties": flag("-g --config", "List the properties of the manager.", multiple=True),
}


@command(
    "rtmgr",
    cls=_InOrder,
    examples=(
        ("rtmgr start", "Start the manager of this host in the background."),
        ("rtmgr start other -p 2811 -f robot.conf", "Another one, with a port and properties."),
        ("rtmgr -m corbaloc::localhost:2811", "What the manager at that port could load."),
        ("rtmgr -c ConsoleIn -c ConsoleOut /localhost/manager.mgr", "Make two components."),
        (
            "rtmgr -c 'Motor?instance_name=Left&manager_name=drives' /localhost/manager.mgr",
            "In a slave process of its own, which is started when it is not there.",
        ),
        (
            "rtmgr -l ./Arm.py:ArmInit -c Arm --print /localhost/manager.mgr",
            "Load a module, make a component with it, tell where it is found.",
        ),
        ("rtmgr -d Left /localhost/manager.mgr", "Finalise a component and forget it."),
        ("rtmgr dump", "Write down what the manager did last, in manager.dump."),
        ("rtmgr replay manager.dump", "What it did at each event, done again here."),
        ("rtmgr install --print", "Show the systemd unit that makes a service of it."),
        ("rtmgr restart", "End all in order, and make all again as it was."),
        ("rtmgr stop", "End the manager with everything that it holds."),
    ),
    json=("properties", "instance", "component-type", "manager-status", "replay", "built-file"),
    arguments=("manager|word", "manager-name", "file"),
    values={
        "-c": "type",
        "-d": "instance",
        "-l": "module",
        "-s": "property",
        "-u": "loaded-module",
    },
    words=WORDS,
)
def main(
    app: App,
    _steps: None = together(None, _STEPS),
    is_printing: bool = flag("--print", "Print paths of created components; install: the unit."),
    is_json: bool = json_flag("Lists, status and the installed unit's path as JSON."),
    file: str = option("-f --file FILE", "start: the rtc.conf to read.", default=""),
    given: tuple[str, ...] = several("-o --option KEY:VALUE", "start: a property."),
    port: int | None = option(
        "-p --port PORT", "start: TCP port (default 2810); 0 for any.", click.IntRange(0, 65535)
    ),
    no_door: bool = flag("-a --no-door", "start: no TCP port at all."),
    tls: str = option("--tls [ADDRESS:]PORT", "start: port for certificates (rtkit keys)."),
    lenient: bool = flag("-i --lenient", "start: the file may be missing."),
    allow_faults: bool = flag("--allow-faults", "start: root's manager heeds RTKIT_FAULT."),
    options: WordOptions = together(WordOptions),
    strict: None = strict_option(
        "Take warnings, and notes on what is made, for errors; nothing of it stays."
    ),
    words: tuple[str, ...] = arguments(
        "MANAGER | start|stop|restart|status|run|install|uninstall [NAME]"
        " | dump [NAME [FILE]] | replay FILE"
    ),
) -> int:
    r"""Start, stop, install and command managers.

    start, stop, restart, status and run (in the foreground) take the name of a manager, by
    default "manager". start and run read its properties from FILE, else from the file that
    RTC_MANAGER_CONFIG names, ./rtc.conf, or one in /etc; what -o says counts more. Everything
    else is asked of the manager at a path, or at a direct address as corbaloc::localhost:2810,
    in the order of the command line and in one batch, and ends at the first failure.

    stop forgets what it ends, unless it is to --keep it for the next start; restart makes all
    again as it was, unless it is to --forget. install writes the unit that makes a service of
    systemd of a manager, with what start takes and the folder it is called in, and tells what
    starts it; the service keeps what its manager holds. See rtkit help survival.

    dump writes the last events of a manager, with the state that they began in, to a new FILE,
    by default NAME.dump, which replay reads: it shows what the manager did at each, and that it
    ends alike. At a fault of its own a manager leaves such a file beside its log. Only this user
    can read it; it holds what components, properties and configurations hold, but for texts that
    are named like a password, a secret or a token.

    With --host start brings rtkit and its manager up on hosts of rthost list, all at the same time,
    and links them to the manager here; what is there is used, and what was interrupted is typed
    again. Each host has a line of what was done. -v tells its steps, as a terminal does. stop ends
    the link first, so it lets a lost host go, too. A NAME is that of the manager there.

    With --tls managers are reached from other hosts, as /ADDRESS:PORT, by who shows a certificate
    (rtkit keys): a viewer looks, an operator changes states, configurations and connections of what
    is there and calls operations, an administrator makes and ends things, restarts the manager and
    links hosts (rthost add NAME tls:ADDRESS:PORT).

    A manager in the foreground ends in order at Ctrl-C, when its terminal is closed, and at
    Ctrl-\ after telling where each thread is; a second Ctrl-C ends it at once.

    CREATE is TYPE?key=value&key=value, for instance ConsoleIn?instance_name=In0&manager_name=s1,
    where manager_name is the slave that is to hold the component and is started when needed; in
    place of TYPE the file of an RTC profile makes a stand-in. Paths of modules that begin with
    ./ or ../ are meant from here, others are looked for by the manager.
    """
    asked = click.get_current_context().meta[_ORDER]
    faults = [f"{fault.ALLOW_KEY}:YES"] if allow_faults else []
    overrides = (*given, *_endpoint(port, no_door, tls), *faults)
    is_configured = bool(file or overrides or lenient)
    if words and words[0] in WORDS:
        if words[0] == "install" and is_json and is_printing:
            raise UsageProblem("--print shows the unit as it is: no --json")
        _check_word(words, bool(asked), is_configured, options)
        properties = (*overrides, *_strict_properties(app.is_strict))
        shows = "json" * is_json or "text" * is_printing
        return _word(app, words, options, (file, properties, lenient), shows)
    if is_configured:
        raise UsageProblem(f"{_FOR_START} are for rtmgr {_OF_START}")
    options.check("")
    check_at_most_one(words, "manager")
    from rtkit.cli.managers.steps import read_step

    steps = [read_step(name, str(value)) for name, value in asked]
    if not words:
        raise Malformed("No manager specified.")
    if not steps:
        _check_no_word(words[0])
        raise Malformed("No commands specified.")
    _command(app, words[0], steps, is_printing, is_json)
    return 0


def _strict_properties(is_strict: bool) -> list[str]:
    if not is_strict:
        return []
    from rtkit.settings.properties import STRICT

    return [f"{STRICT}:YES"]


def _check_no_word(typed: str) -> None:
    """Refuse a mistyped word: the path of a manager looks otherwise."""
    from rtkit.rtc.names import MANAGER_SUFFIX
    from rtkit.rtc.nearest import did_you_mean

    if "/" not in typed and ":" not in typed and not typed.endswith(MANAGER_SUFFIX):
        hint = did_you_mean(typed, WORDS) or f" (one of {', '.join(WORDS)})"
        raise UsageProblem(f"neither the path of a manager nor a word: {typed}{hint}")


def _command(
    app: App, typed: str, steps: Sequence[ManagerStep], is_printing: bool, is_json: bool
) -> None:
    from rtkit.cli.managers.steps import StepRunner
    from rtkit.tree.resolve import manager

    if typed.startswith("corbaloc:"):
        node = _at_address(app, typed)
    else:
        node = app.node(manager, app.path(typed))
    StepRunner(app, node, is_printing, is_json).run(steps)


def _at_address(app: App, typed: str) -> TreeNode:
    """Return the manager, or the slave, at a direct address; it needs no name in the tree."""
    from rtkit.rtc.manager_address import parse_address
    from rtkit.tree.view import manager_node

    address = parse_address(typed)
    why = f"no manager named {address.id} answers at {address}: {typed}"
    try:
        tree, slave = app.at(address)
        node = manager_node(tree.listing(), slave)
    except Unreachable as error:
        raise Unreachable(f"{why} ({error})") from error
    if node is None:
        raise Unreachable(why)
    return node


def _endpoint(port: int | None, no_door: bool, tls: str) -> list[str]:
    if no_door and port is not None:
        raise UsageProblem("a port (-p) and no port at all (-a) exclude each other")
    secure = [f"net.tls:{tls}"] if tls else []
    if no_door:
        return ["manager.net_servant:NO", *secure]
    return secure if port is None else [f"net.endpoints:localhost:{port}", *secure]


def _check_word(
    words: Sequence[str], has_steps: bool, is_configured: bool, options: WordOptions
) -> None:
    if has_steps:
        raise UsageProblem(f"{words[0]} takes no options that command a manager")
    if is_configured and words[0] not in ("start", "run", "install"):
        raise UsageProblem(f"{_FOR_START} are not for {words[0]}")
    options.check(words[0])
    if words[0] == "replay":
        if len(words) == 1:
            raise UsageProblem("replay takes the file of a dump")
        check_at_most_one(words[1:], "file")
    elif words[0] == "dump":
        check_at_most_one(words[2:], "file")
    else:
        check_at_most_one(words[1:], "name")


def _word(
    app: App,
    words: Sequence[str],
    options: WordOptions,
    wanted: tuple[str, tuple[str, ...], bool],
    shows: str,
) -> int:
    if words[0] == "replay":
        from rtkit.cli.managers.words import replay

        return replay(app, words[1], shows == "json")
    from rtkit.cli.managers.words import run_word

    name, file = (*words[1:], "", "")[:2]
    return run_word(app, words[0], name, options, wanted, shows, file)
