"""``rtkit help TOPIC``: texts on topics of more than one command, and the table of statuses."""

from __future__ import annotations

import os

_FOLDER = os.path.join(os.path.dirname(__file__), "texts")
TOPICS: dict[str, str] = {
    "authors": "What a component consists of, for its author.",
    "connectors": "How values travel between two ports.",
    "limits": "The most that slaves may use of memory, processes, files, processors.",
    "parameters": "One system profile with other values, and several times.",
    "paths": "How components, managers, directories and ports are named.",
    "placement": "Hosts that are chosen by what components require: tags, memory, devices.",
    "planner": "How a planning problem of your own is modelled and solved.",
    "plans": "In which order rtstart and rtstop tell components.",
    "profiles": "Documents that describe components and systems.",
    "security": "Who can reach a manager, and what it runs.",
    "states": "What a system is to be like in each of its states.",
    "statuses": "What the exit status of a command says.",
    "survival": "What is there again after a crash, and a loss of power.",
    "testing": "How components are tested, without and with a manager.",
    "types": "Data types and interfaces of your own, from IDL or as classes.",
    "wires": "Wires of live properties, and the forms of their addresses.",
}


def overview(name: str) -> str:
    """Return the list of help topics."""
    width = max(map(len, TOPICS)) + 2
    topics = "\n".join(f"  {topic:<{width}}{about}" for topic, about in TOPICS.items())
    return f"""Usage: {name} help [TOPIC|VERB]

Topics:
{topics}

{name} help VERB tells about a command, as {name} VERB -h does; {name} -h lists them.

Examples:
  {name} help paths  How things are named.
  {name} help ls     The same as rtls -h."""


def text(topic: str) -> str:
    """Return the text of a topic."""
    if topic in _DERIVED:
        return _DERIVED[topic]()
    with open(os.path.join(_FOLDER, f"{topic}.txt"), encoding="utf-8") as file:
        return file.read().rstrip()


def _statuses() -> str:
    lines = ["Statuses: what the exit status of a command says.", ""]
    lines += [f"  {status:<5}{meaning}" for status, meaning in STATUSES.items()]
    lines += ["", f"{EXIT_DETAIL_NOTE}:", ""]
    lines += [f"  {status:<5}{meaning}" for status, meaning in DETAILS.items()]
    return "\n".join(lines)


def _wires() -> str:
    from rtkit.wires.table import WIRES, wires

    lines = [
        "Wires: how live properties travel, and the forms of their addresses.",
        "",
        "Commands find the services of this host by their names (rtget robot.speed).",
        "Elsewhere an address says where a service is, and on which wire.",
    ]
    for wire in wires():
        forms = {
            "rtproxy FROM": wire.source,
            "rtproxy ... TO": wire.target,
            "rtget, rtset, rtlisten": wire.client and f"{wire.source}/NAME",
            "rtserve": (option := WIRES[wire.scheme].option)
            and f"--{option.name} {option.metavar}",
            "needs": wire.extra and f"pip install 'rtkit[{wire.extra}]'",
        }
        lines += ["", f"{wire.scheme}: {wire.summary}"]
        lines += [f"  {use:<24}{form}" for use, form in forms.items() if form]
    lines += ["", "A name of the tree as TO is where commands and zenoh find the proxy."]
    return "\n".join(lines)


_DERIVED = {"statuses": _statuses, "wires": _wires}


STATUSES: dict[str, str] = {
    "0": "Success.",
    "1": "It could not be done, or something else was found than was to be.",
    "2": "The command line cannot be read.",
    "130": "Interrupted, as a shell shows it: the command ends by the signal.",
    "141": "Who read its output has gone: rtls -R | head -n 1.",
}
DETAILS: dict[str, str] = {
    "1": "refused",
    "2": "malformed",
    "3": "invalid document",
    "4": "not found",
    "5": "no answer",
    "6": "only a part was done",
    "7": "impossible",
    "8": "a search was given up",
    "70": "a bug",
}
"""Exit statuses that tell failures apart with ``--exit-detail``."""
EXIT_DETAIL_NOTE = "With --exit-detail (or RTKIT_EXIT_DETAIL=1) failures are told apart"
