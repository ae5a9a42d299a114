"""``rtkit help TOPIC``: texts on topics that concern more than one command."""

from __future__ import annotations

import os

from rtkit.cli.help.statuses import DETAILS, STATUSES, TOLD_APART

_FOLDER = os.path.join(os.path.dirname(__file__), "texts")
TOPICS: dict[str, str] = {
    "connectors": "How values travel between two ports.",
    "limits": "The most that slaves may use of memory, processes, files, processors.",
    "paths": "How components, managers, directories and ports are named.",
    "plans": "In which order rtstart and rtstop tell components.",
    "profiles": "Documents that describe components and systems.",
    "security": "Who can reach a manager, and what it runs.",
    "states": "What a system is to be like in each of its states.",
    "statuses": "What the exit status of a command says.",
    "survival": "What is there again after a crash, and a loss of power.",
}


def overview(name: str) -> str:
    """Return the list of help topics."""
    width = max(map(len, TOPICS)) + 2
    topics = "\n".join(f"  {topic:<{width}}{about}" for topic, about in TOPICS.items())
    return f"""Usage: {name} help [TOPIC|VERB]

Topics:
{topics}

{name} help VERB tells about a command, as {name} VERB -h does; {name} -h lists them."""


def text(topic: str) -> str:
    """Return the text of a topic."""
    if topic == "statuses":
        return _statuses()
    with open(os.path.join(_FOLDER, f"{topic}.txt"), encoding="utf-8") as file:
        return file.read().rstrip()


def _statuses() -> str:
    lines = ["Statuses: what the exit status of a command says.", ""]
    lines += [f"  {status:<5}{meaning}" for status, meaning in STATUSES.items()]
    lines += ["", f"{TOLD_APART}:", ""]
    lines += [f"  {status:<5}{meaning}" for status, meaning in DETAILS.items()]
    return "\n".join(lines)
