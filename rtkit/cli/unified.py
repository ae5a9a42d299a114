"""``rtkit VERB …``: dispatches to all commands, importing only the one asked for."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from rtkit.cli.shared.commands import COMMANDS, COMPLETE, HELP, SHELL_INIT, SUMMARIES, WORDS, load
from rtkit.cli.shared.console_process import write

if TYPE_CHECKING:
    from rtkit.tree.client import Tree

_USAGE = "Usage: {} VERB [OPTIONS] [ARGUMENTS]..."
_BAD_LINE = 2
EXAMPLES = (
    ("rtkit ls /localhost", "The same as rtls /localhost."),
    ("rtkit conf -h", "Tell about one verb."),
    ("rtkit shell-init bash", "What bash evaluates to know rtcwd."),
)
"""Command lines, each with what it does."""
_WRONG_COUNT = 1


def run(argv: Sequence[str] | None = None, tree: Tree | None = None) -> int:
    """Run the command that the first argument names and return its exit status."""
    name = "rtkit" if argv is not None else os.path.basename(sys.argv[0])
    arguments = list(sys.argv[1:] if argv is None else argv)
    verb = arguments[0] if arguments else "--help"
    if verb in ("-h", "--help"):
        return write(name, _help(name))
    if verb == "--version":
        from rtkit import __version__

        return write(name, f"rtkit {__version__}")
    if verb == SHELL_INIT:
        return _shell_init(name, arguments[1:])
    if verb == HELP:
        if arguments[1:2] and arguments[1] in (*COMMANDS, *COMMANDS.values()):
            return _run(name, arguments[1], ["-h"], is_script=argv is None, tree=tree)
        return _help_topic(name, arguments[1:])
    if verb == COMPLETE:
        return _complete(name, arguments[1:], tree)
    if verb not in COMMANDS and verb not in COMMANDS.values():
        return _unknown(name, verb)
    return _run(name, verb, arguments[1:], is_script=argv is None, tree=tree)


def _run(
    name: str, verb: str, arguments: Sequence[str], *, is_script: bool, tree: Tree | None
) -> int:
    main = load(verb)
    if is_script:
        return main.as_script(arguments, f"{name} {verb}")
    return main(arguments, tree=tree, name=f"{name} {verb}")


def _help_topic(name: str, arguments: Sequence[str]) -> int:
    from rtkit.cli.help.topics import TOPICS, overview, text

    command = f"{name} {HELP}"
    if not arguments or arguments[0] in ("-h", "--help"):
        return write(command, overview(name))
    usage = f"Usage: {name} help [TOPIC|VERB]"
    if len(arguments) > 1:
        return _refuse(usage, f"{command}: takes one topic, not also: {' '.join(arguments[1:])}", 1)
    if arguments[0] in TOPICS:
        return write(command, text(arguments[0]))
    from rtkit.rtc.nearest import did_you_mean

    known = [*TOPICS, *COMMANDS, *COMMANDS.values()]
    hint = did_you_mean(arguments[0], known) or f" (one of {', '.join(TOPICS)})"
    return _refuse(usage, f"{command}: no such topic: {arguments[0]}{hint}", _BAD_LINE)


def _refuse(usage: str, why: str, status: int) -> int:
    from rtkit.cli.shared.terminal import printable

    print(usage, file=sys.stderr)
    print(printable(why), file=sys.stderr)
    return status


def _shell_init(name: str, arguments: Sequence[str]) -> int:
    from rtkit.cli.completion.functions import HELP, SHELLS, script

    help_text = HELP.format(name)
    if len(arguments) == 1 and arguments[0] in ("-h", "--help"):
        return write(f"{name} {SHELL_INIT}", help_text)
    if len(arguments) == 1 and arguments[0] in SHELLS:
        return write(f"{name} {SHELL_INIT}", script(arguments[0]))
    usage = help_text.splitlines()[0]
    if len(arguments) != 1:
        print(usage, file=sys.stderr)
        return _WRONG_COUNT
    why = f"{name} shell-init: no such shell: {arguments[0]} (one of {', '.join(SHELLS)})"
    return _refuse(usage, why, _BAD_LINE)


def _complete(name: str, arguments: Sequence[str], tree: Tree | None) -> int:
    from rtkit.cli.completion.answer import USAGE, complete

    if arguments[:1] in (["-h"], ["--help"]):
        return write(f"{name} {COMPLETE}", USAGE.format(name, name))
    return complete(name, arguments, tree)


def _help(name: str) -> str:
    summaries = SUMMARIES | WORDS
    width = max(map(len, summaries)) + 2
    lines = max(len(line) for line, _ in EXAMPLES) + 2
    examples = "\n".join(f"  {line:<{lines}}{does}" for line, does in EXAMPLES[:2])
    verbs = "\n".join(f"  {verb:<{width}}{summaries[verb]}" for verb in sorted(summaries))
    return f"""{_USAGE.format(name)}

Each verb is also a command of its own: {name} ls is rtls.

Verbs:
{verbs}

Options:
  --version   Show the version and exit.
  -h, --help  Show this message.

{name} VERB -h tells more.

Examples:
{examples}"""


def _unknown(name: str, verb: str) -> int:
    from rtkit.rtc.nearest import did_you_mean

    what, known, all_of = (
        "verb",
        [*COMMANDS, *COMMANDS.values(), *WORDS],
        f"{name} --help lists them",
    )
    if verb.startswith("-"):
        what, known, all_of = "option", ["--help", "--version"], "--help, --version"
    hint = did_you_mean(verb, known) or f" ({all_of})"
    return _refuse(_USAGE.format(name), f"{name}: no such {what}: {verb}{hint}", _BAD_LINE)
