"""Write what is made of the commands: their table, console scripts and manual pages.

Usage: ``python tools/make_commands.py [man]``; with ``man`` the pages only. A test checks that
`rtkit.cli.table`, ``pyproject.toml``, ``man/`` and two tables of ``docs/`` hold what this makes.
"""

from __future__ import annotations

import importlib
import re
import sys
from collections.abc import Container, Iterator
from functools import cache
from inspect import cleandoc
from pathlib import Path

import click

from rtkit import __version__, cli
from rtkit.cli.help.topics import DETAILS, EXIT_DETAIL_NOTE, STATUSES, TOPICS
from rtkit.cli.shared.command import Main
from rtkit.cli.shared.commands import TABLE as LOADED
from rtkit.cli.shared.commands import WORDS
from rtkit.cli.shared.group import CommandGroup
from rtkit.cli.unified import EXAMPLES

ROOT = Path(__file__).parents[1]
TABLE = ROOT / "rtkit" / "cli" / "table.py"
PROJECT = ROOT / "pyproject.toml"
COMMANDS_PAGE = ROOT / "docs" / "commands.md"
JSON_PAGE = ROOT / "docs" / "json.md"
_WIDTH = 100

_ENVIRONMENT = (
    ("RTKIT_MANAGER", "Name of the manager to ask, by default manager."),
    ("RTKIT_HOSTNAME", "Name of this host in the tree, by default that of the machine."),
    ("RTKIT_SSH_CONFIG", "File that is read as OpenSSH's, by default ~/.ssh/config."),
    ("RTKIT_KEYS", "Folder of keys, by default rtkit/keys in the configuration folder."),
    ("RTKIT_CWD", "Working directory in the tree, from which relative paths are meant."),
    ("RTCSH_CWD", "The same, where RTKIT_CWD is not set: the variable that rtcwd sets."),
    ("RTKIT_RUNTIME_DIR", "Folder of sockets and locks, for this user alone."),
    ("RTKIT_STATE_DIR", "Folder of logs, of the store and of the door's secret."),
    ("RTKIT_MODULE_PATH", "Folders where managers look for modules, with : between them."),
    ("RTKIT_PROFILE_PATH", "Folders where RTC profiles are looked for, with : between them."),
    ("RTKIT_REPOSITORIES", "Where rtpkg looks for packages, with ; between."),
    ("RTKIT_SIGNED", "1 has only signed packages installed."),
    ("RTKIT_SERVERS", "Managers elsewhere that are shown in the tree, HOST:PORT with ; between."),
    ("RTKIT_PORT", "TCP port at which a manager begins to listen, or none."),
    ("RTKIT_REALM", "Systems of different realms never meet; by default default."),
    ("RTKIT_MQTT_PASSWORD", "Password for the user that an mqtt: address names."),
    ("RTKIT_COMPLETION_TIMEOUT", "How long TAB waits for a manager, in seconds; by default 1."),
    ("RTKIT_EXIT_DETAIL", "1 has failures told apart by the exit status."),
    ("RTKIT_TIMEOUT", "Bound on every call, in seconds; RTKIT_RTLS_TIMEOUT that of rtls only."),
    ("RTKIT_RTLS_JSON", "1 has rtls write JSON; so for each option with a long name of a command."),
    ("NO_COLOR, FORCE_COLOR", "Never, or always, colour what goes to stdout."),
)


@cache
def commands() -> dict[str, tuple[str, Main]]:
    """Return module and command by name, ``rtprofile show`` too, found by their files."""
    files = sorted(Path(cli.__file__).parent.glob("*/rt*.py"), key=lambda file: file.stem)
    found = {file.stem: _imported(file) for file in files}
    for name, (module, main) in list(found.items()):
        if isinstance(main.command, CommandGroup):
            folder = Path(importlib.import_module(module).__file__ or "").parent / "words"
            words = [_imported(file) for file in folder.glob("[a-z]*.py")]
            known = {each.name: (at, each) for at, each in words}
            words_of = {f"{name} {word}": known[word] for word in main.command.words}
            found |= words_of
            # A new word is not in the table yet, by which its group finds it.
            LOADED.update(
                {word: (at, "") for word, (at, _) in words_of.items() if word not in LOADED}
            )
    return found


def _imported(file: Path) -> tuple[str, Main]:
    module = ".".join(file.relative_to(Path(cli.__file__).parents[2]).with_suffix("").parts)
    return module, importlib.import_module(module).main


def summary(main: Main) -> str:
    """Return the first sentence of the help."""
    text = " ".join((main.command.help or "").partition("\n\n")[0].split())
    first = text.partition(". ")[0].removesuffix(".")
    return f"{first.replace(' (FILE, or stdin)', '')}."


def examples() -> dict[str, tuple[tuple[str, str], ...]]:
    """Return the examples of each command; those of subcommands are their group's, too."""
    found = {name: tuple(main.examples) for name, (_, main) in commands().items()}
    for name in [name for name in found if " " in name]:
        found[name.partition(" ")[0]] += found.pop(name)
    return {**found, "rtkit": EXAMPLES}


def table() -> str:
    """Return the text of the module `rtkit.cli.table`."""
    topics: dict[str, list[str]] = {}
    for module, main in commands().values():
        topic, _, stem = module.removeprefix("rtkit.cli.").rpartition(".")
        topics.setdefault(topic, []).append(f'        "{stem}": "{summary(main)}",')
    lines = [
        line
        for topic in sorted(topics)
        for line in (f'    "{topic}": {{', *sorted(topics[topic]), "    },")
    ]
    return "\n".join(
        [
            '"""Lists commands by topic, each with its summary; written by "make commands"."""',
            "",
            "TOPICS: dict[str, dict[str, str]] = {",
            *lines,
            "}",
            '"""Summary of each module, a command each, by the package that it is in."""',
            "",
        ]
    )


def project() -> str:
    """Return the text of ``pyproject.toml`` with a console script for each command."""
    scripts = [f'{name} = "{module}:main"' for name, (module, _) in _scripts()]
    lines = "\n".join(["[project.scripts]", 'rtkit = "rtkit.cli:main"', *scripts, "", ""])
    text = PROJECT.read_text(encoding="utf-8")
    return re.sub(r"\[project\.scripts\]\n.*?\n\n", lines, text, flags=re.DOTALL)


def commands_page() -> str:
    """Return the page of commands, with a row for each command that has none yet."""
    text = COMMANDS_PAGE.read_text(encoding="utf-8")
    cells = "".join(re.findall(r"^\| (.*?) \|", text.partition("\n## ")[0], flags=re.MULTILINE))
    lacking = [(name, main) for name, (_, main) in _scripts() if f"`{name}`" not in cells]
    return _with_rows(
        text, [f"| `{name}` | {_in_a_row(summary(main))} |" for name, main in lacking]
    )


def json_page() -> str:
    """Return the page of JSON with each command in the rows of what it writes.

    What is written there by hand stays: only names that lack are added.
    """
    text = JSON_PAGE.read_text(encoding="utf-8")
    for name, (_, main) in commands().items():
        for kind in main.json:
            row = re.search(rf"^\| [^|]*`{kind}`[^|]* \| .*$", text, flags=re.MULTILINE)
            if row is None:
                text = _with_rows(text, [f"| `{kind}` | `{name}` |"])
            elif f"`{name}" not in row[0] and f"`{main.name}" not in row[0]:
                kinds, bar, by = row[0].partition(" | ")
                text = text.replace(row[0], f"{kinds}{bar}`{name}`, {by}")
    return text


def _with_rows(text: str, rows: list[str]) -> str:
    """Add rows to the first table of a page."""
    head, end, rest = text.partition(" |\n\n")
    return " |\n".join([head, *(row.removesuffix(" |") for row in rows)]) + end + rest


def _in_a_row(summary: str) -> str:
    return summary[0].lower() + summary[1:].removesuffix(".")


def written() -> dict[Path, str]:
    """Return the text of each file, but the manual pages, that is made of the commands."""
    return {
        TABLE: table(),
        PROJECT: project(),
        COMMANDS_PAGE: commands_page(),
        JSON_PAGE: json_page(),
    }


def _scripts() -> Iterator[tuple[str, tuple[str, Main]]]:
    return ((name, each) for name, each in commands().items() if " " not in name)


def pages() -> dict[str, str]:
    """Return the text of each manual page by file name."""
    made = {f"{name}.1": _page(name, main) for name, (_, main) in _scripts()}
    return {**made, "rtkit.1": _unified()}


def _page(name: str, main: Main) -> str:
    command = main.command
    context = click.Context(command, info_name=name, **command.context_settings)
    usage = " ".join(filter(None, command.collect_usage_pieces(context)))
    lines = [*_head(name, summary(main), usage), ".SH DESCRIPTION"]
    lines += _paragraphs(cleandoc(command.help or ""))
    lines.append(".SH OPTIONS")
    lines += _options(command, context)
    if isinstance(command, CommandGroup):
        lines.append(".SH COMMANDS")
        for word in command.words:
            lines += _word(command, word, context)
    # That page names all commands; if each page did, a new command would change every page.
    return _text([*lines, *_tail(name, main), ".SH SEE ALSO", "rtkit(1)"])


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
    for name, (_, main) in _scripts():
        lines += _item(name[2:], f"{summary(main)} See {name}(1).")
    for word, about in WORDS.items():
        lines += _item(word, f"{about} Tells more with -h.")
    lines += [".SH TOPICS", "What rtkit help tells about:"]
    for topic, about in TOPICS.items():
        lines += _item(topic, about)
    lines += [".SH OPTIONS"]
    lines += _item("--version", "Show the version and exit.")
    lines += _item("-h, --help", "List the verbs.")
    return _text([*lines, *_tail("rtkit", None)])


def _head(name: str, summary: str, usage: str) -> Iterator[str]:
    yield f'.TH {name.upper()} 1 "" "rtkit {__version__}" "rtkit"'
    yield ".SH NAME"
    yield f"{name} \\- {_escape(_in_a_row(summary))}"
    yield ".SH SYNOPSIS"
    yield f".B {name}"
    yield _escape(usage)


def _tail(name: str, main: Main | None) -> Iterator[str]:
    if main is not None and main.json:
        yield ".SH JSON"
        yield _escape(f"Records that --json writes: {', '.join(main.json)}.")
    yield ".SH EXIT STATUS"
    own = main.statuses if main is not None else {}
    for status, meaning in {**STATUSES, **own}.items():
        yield from _item(status, meaning)
    yield ".PP"
    told = ", ".join(f"{status} {meaning}" for status, meaning in DETAILS.items())
    yield _escape(f"{EXIT_DETAIL_NOTE}: {told}.")
    yield ".SH ENVIRONMENT"
    for variable, meaning in _ENVIRONMENT:
        yield from _item(variable, meaning)
    yield ".SH EXAMPLES"
    for line, meaning in examples()[name]:
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


def main(wanted: list[str]) -> None:
    """Write what is stale, and remove the pages of commands that went."""
    folder = ROOT / "man"
    made = {folder / name: text for name, text in pages().items()}
    if wanted != ["man"]:
        made |= written()
    for file in folder.glob("*.1"):
        if file not in made:
            file.unlink()
    for file, text in made.items():
        if not file.exists() or file.read_text(encoding="utf-8") != text:
            file.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])
