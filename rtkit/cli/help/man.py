"""Writes the manual pages from the commands: ``python -m rtkit.cli.help.man FOLDER``."""

from __future__ import annotations

import os
import sys
from collections.abc import Container, Iterator
from inspect import cleandoc

import click

from rtkit import __version__
from rtkit.cli import COMMANDS, load
from rtkit.cli.help.examples import EXAMPLES
from rtkit.cli.help.statuses import DETAILS, STATUSES, TOLD_APART
from rtkit.cli.help.topics import TOPICS
from rtkit.cli.help.verbs import SUMMARIES, WORDS
from rtkit.cli.shared.group import CommandGroup

_ENVIRONMENT = (
    ("RTKIT_MANAGER", "Name of the manager to ask, by default manager."),
    ("RTKIT_CWD", "Working directory in the tree, from which relative paths are meant."),
    ("RTCSH_CWD", "The same, where RTKIT_CWD is not set: the variable that rtcwd sets."),
    ("RTKIT_RUNTIME_DIR", "Folder of sockets and locks, for this user alone."),
    ("RTKIT_STATE_DIR", "Folder of logs, of the store and of the door's secret."),
    ("RTKIT_MODULE_PATH", "Folders where managers look for modules, with : between them."),
    ("RTKIT_PROFILE_PATH", "Folders where RTC profiles are looked for, with : between them."),
    ("RTKIT_SERVERS", "Managers elsewhere that are shown in the tree, HOST:PORT with ; between."),
    ("RTKIT_PORT", "TCP port at which a manager begins to listen, or none."),
    ("RTKIT_REALM", "Systems of different realms never meet; by default default."),
    ("RTKIT_MQTT_PASSWORD", "Password for the user that an mqtt: address names."),
    ("RTKIT_COMPLETION_TIMEOUT", "How long TAB waits for a manager, in seconds; by default 1."),
    ("RTKIT_EXIT_DETAIL", "1 has failures told apart by the exit status."),
    ("NO_COLOR, FORCE_COLOR", "Never, or always, colour what goes to stdout."),
)


def pages() -> dict[str, str]:
    """Return the text of each page by file name."""
    made = {f"{module}.1": _page(verb, module) for verb, module in COMMANDS.items()}
    return {**made, "rtkit.1": _unified()}


def _page(verb: str, name: str) -> str:
    command = load(name).command
    context = click.Context(command, info_name=name, **command.context_settings)
    usage = " ".join(filter(None, command.collect_usage_pieces(context)))
    lines = [*_head(name, SUMMARIES[verb], usage), ".SH DESCRIPTION"]
    lines += _paragraphs(cleandoc(command.help or ""))
    lines.append(".SH OPTIONS")
    lines += _options(command, context)
    if isinstance(command, CommandGroup):
        lines.append(".SH COMMANDS")
        for word in command.words:
            lines += _word(command, word, context)
    # That page names all commands; if each page did, a new command would change every page.
    return _text([*lines, *_tail(name), ".SH SEE ALSO", "rtkit(1)"])


def _word(group: CommandGroup, word: str, context: click.Context) -> Iterator[str]:
    command = group.get_command(context, word)
    assert command is not None
    inner = click.Context(command, info_name=word, parent=context, **command.context_settings)
    usage = " ".join([word, *command.collect_usage_pieces(inner)])
    yield f'.SS "{_escape(usage)}"'
    yield from _paragraphs(cleandoc(command.help or ""))
    common = {parameter.name for parameter in group.params}
    yield from _options(command, inner, without=common)


def _options(
    command: click.Command, context: click.Context, without: Container[str | None] = ()
) -> Iterator[str]:
    for parameter in command.params if without else command.get_params(context):
        if isinstance(parameter, click.Option) and parameter.name not in without:
            record = parameter.get_help_record(context)
            if record is not None:
                yield from _item(record[0], record[1].partition("  [")[0])


def _unified() -> str:
    lines = [*_head("rtkit", "All commands behind one word.", "VERB [OPTIONS] [ARGUMENTS]...")]
    lines += [".SH DESCRIPTION", "Each verb is also a command of its own, with a page of its own."]
    lines += [".SH VERBS"]
    for verb, module in COMMANDS.items():
        lines += _item(verb, f"{SUMMARIES[verb]} See {module}(1).")
    for word, summary in WORDS.items():
        lines += _item(word, f"{summary} Tells more with -h.")
    lines += [".SH TOPICS", "What rtkit help tells about:"]
    for topic, about in TOPICS.items():
        lines += _item(topic, about)
    lines += [".SH OPTIONS"]
    lines += _item("--version", "Show the version and exit.")
    lines += _item("-h, --help", "List the verbs.")
    return _text([*lines, *_tail("rtkit")])


def _head(name: str, summary: str, usage: str) -> Iterator[str]:
    yield f'.TH {name.upper()} 1 "" "rtkit {__version__}" "rtkit"'
    yield ".SH NAME"
    yield f"{name} \\- {_escape(summary[0].lower() + summary[1:].removesuffix('.'))}"
    yield ".SH SYNOPSIS"
    yield f".B {name}"
    yield _escape(usage)


def _tail(name: str) -> Iterator[str]:
    yield ".SH EXIT STATUS"
    for status, meaning in STATUSES.items():
        yield from _item(status, meaning)
    yield ".PP"
    told = ", ".join(f"{status} {meaning}" for status, meaning in DETAILS.items())
    yield _escape(f"{TOLD_APART}: {told}.")
    yield ".SH ENVIRONMENT"
    for variable, meaning in _ENVIRONMENT:
        yield from _item(variable, meaning)
    yield ".SH EXAMPLES"
    for line, meaning in EXAMPLES[name]:
        yield from _item(line, meaning)


def _paragraphs(help_text: str) -> Iterator[str]:
    for paragraph in help_text.split("\n\n"):
        is_verbatim = paragraph.startswith("\b\n")
        yield ".PP"
        if is_verbatim:
            yield ".nf"
        for line in paragraph.removeprefix("\b\n").splitlines():
            yield _escape(line)
        if is_verbatim:
            yield ".fi"


def _item(term: str, meaning: str) -> Iterator[str]:
    yield ".TP"
    yield f"\\fB{_escape(term)}\\fR"
    yield _escape(meaning)


def _escape(text: str) -> str:
    safe = text.replace("\\", "\\e").replace("-", "\\-")
    return f"\\&{safe}" if safe.startswith((".", "'")) else safe


def _text(lines: list[str]) -> str:
    return "\n".join(
        ['.\\" Written by "make man" from the command itself: change that.', *lines, ""]
    )


def main() -> None:
    """Write every page into the folder named, and remove pages of commands that went."""
    (folder,) = sys.argv[1:]
    os.makedirs(folder, exist_ok=True)
    made = pages()
    for name in os.listdir(folder):
        if name.endswith(".1") and name not in made:
            os.unlink(os.path.join(folder, name))
    for name, text in made.items():
        with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
            file.write(text)


if __name__ == "__main__":
    main()
