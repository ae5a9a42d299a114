"""``rtkit complete``: answers the shell's request for completion when TAB is pressed.

The first line of an answer is ``space``, ``nospace`` (nothing is to follow the only candidate) or
``files ENDING…`` (the shell names files itself). A candidate a line follows: for bash the text to
insert, quoted; for zsh and fish the whole word, a tabulator and its description.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from rtkit.cli.completion.candidates import Candidate, Files, named, those
from rtkit.cli.shared.commands import COMMANDS, SUMMARIES, WORDS
from rtkit.cli.shared.console_process import write
from rtkit.errors import RtkitError

if TYPE_CHECKING:
    from rtkit.tree.client import Tree

USAGE = """\
Usage: {} complete bash TYPE BREAKS LINE
       {} complete zsh|fish WORD... TYPED

What shells ask at TAB, through the functions that shell-init prints: TYPE and BREAKS are
COMP_TYPE and COMP_WORDBREAKS, LINE is what stands before the cursor."""
PATIENCE = "RTKIT_COMPLETION_TIMEOUT"
_PATIENCE_S = 1.0
_LISTING = "63"  # COMP_TYPE of a second TAB in bash: it lists candidates and inserts none
_WORDS_OF = {"shell-init": ("bash", "zsh", "fish")}


def complete(name: str, arguments: Sequence[str], tree: Tree | None = None) -> int:
    """Answer on stdout; errors go to stderr, which shells throw away."""
    try:
        if tree is None:
            from rtkit.settings import layers

            layers.read().apply()
        lines = _lines(arguments, tree)
    except RtkitError as error:
        print(f"{name} complete: {error}", file=sys.stderr)
        return error.exit_code
    if not lines:
        print(USAGE.format(name, name), file=sys.stderr)
        return 2
    return write(f"{name} complete", "\n".join(lines))


def _lines(arguments: Sequence[str], tree: Tree | None) -> list[str]:
    if arguments[:1] == ["bash"] and len(arguments) == 4:
        _, kind, breaks, text = arguments
        return _for_bash(kind, breaks, text, tree)
    if arguments[:1] in (["zsh"], ["fish"]) and len(arguments) > 2:
        return _for_words(arguments[0], list(arguments[1:-1]), arguments[-1], tree)
    return []


def _for_words(shell: str, words: Sequence[str], typed: str, tree: Tree | None) -> list[str]:
    from rtkit.cli.completion.line import unquoted

    found = candidates(words, unquoted(typed) if shell == "fish" else typed, tree)
    if isinstance(found, Files):
        return [" ".join(("files", *(found.endings or ("/",) * found.is_folder)))]
    return ["space", *(f"{each.text}\t{each.about}" for each in found)]


def _for_bash(kind: str, breaks: str, text: str, tree: Tree | None) -> list[str]:
    from rtkit.cli.completion.line import read

    line = read(text, breaks)
    found = candidates(line.words, line.typed, tree)
    if isinstance(found, Files):
        found = named(found, line.typed)
    while line.quote and len(found) == 1 and found[0].is_open:
        # Bash closes the quote behind the only candidate: it gets those of the next level.
        deeper = candidates(line.words, found[0].text, tree)
        deeper = named(deeper, found[0].text) if isinstance(deeper, Files) else deeper
        if not deeper or deeper == found:
            break
        found = deeper
    if kind == _LISTING and len(found) > 1:
        return ["nospace", *(shown(each.text) for each in found)]
    ends = "nospace" if any(each.is_open for each in found) else "space"
    return [ends, *(line.replacement(each.text) for each in found)]


def shown(text: str) -> str:
    """Return the part of a word that a list shows: the last name of a path, with its port."""
    head, slash, name = text.rstrip("/").rpartition("/")
    return f"{name}{text[len(head) + len(slash) + len(name) :]}"


def candidates(
    words: Sequence[str], typed: str, tree: Tree | None = None
) -> list[Candidate] | Files:
    """Return the candidates behind words of a command line; the first word is the command.

    Raises:
        RtkitError: The manager or service does not answer, or a word before cannot be read.
    """
    name, *before = [os.path.basename(words[0]), *words[1:]] if words else [""]
    if name == "rtkit":
        if not before:
            return _verbs(typed)
        name, *before = [COMMANDS.get(before[0], before[0]), *before[1:]]
        if name in _WORDS_OF and not before:
            return those(_WORDS_OF[name], typed)
        if name == "help" and not before:
            from rtkit.cli.help.topics import TOPICS

            topics = [Candidate(topic, about) for topic, about in TOPICS.items()]
            return [*(each for each in topics if each.text.startswith(typed)), *_verbs(typed)]
    from rtkit.cli.completion.grammar import ask

    asked = ask(name, before, typed)
    if asked is None:
        return []
    if asked.kind in ("option", "words"):
        found: list[Candidate] | Files = [
            each for each in asked.words if each.text.startswith(asked.typed)
        ]
    else:
        from rtkit.cli.completion.live import CompletionSource

        live = CompletionSource(_bounded(), tree)
        try:
            from rtkit.cli.completion import argument_types

            made = argument_types.found(asked, live)
            found = made if isinstance(made, Files) else list(made)
        finally:
            live.close()
    if isinstance(found, Files) or not asked.front:
        return found
    return [each._replace(text=asked.front + each.text) for each in found]


def _verbs(typed: str) -> list[Candidate]:
    summaries = {**SUMMARIES, **WORDS, "--version": "", "--help": ""}
    return [Candidate(word, about) for word, about in summaries.items() if word.startswith(typed)]


def _bounded() -> float:
    """Return the time-out for a manager [s]; this process ends when it takes longer."""
    try:
        timeout_s = float(os.environ.get(PATIENCE, ""))
    except ValueError:
        timeout_s = _PATIENCE_S
    if timeout_s > 0 and signal.getsignal(signal.SIGALRM) is signal.SIG_DFL:
        signal.signal(signal.SIGALRM, lambda *_: os._exit(1))
        signal.setitimer(signal.ITIMER_REAL, timeout_s)
    return timeout_s if timeout_s > 0 else _PATIENCE_S
