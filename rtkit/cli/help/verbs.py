"""The verbs of ``rtkit``, each with a summary of one line."""

from __future__ import annotations

SUMMARIES: dict[str, str] = {
    "act": "Activate components: Inactive to Active.",
    "apply": "Make the live system what an RTS profile says.",
    "build": "Generate a component from its RTC profile.",
    "cat": "Describe a component, a port or a manager.",
    "check": "Compare the live system with an RTS profile.",
    "comp": "Make and change composite components.",
    "con": "Connect the first port to each of the others.",
    "conf": "Show and change the configuration sets of a component.",
    "cryo": "Save the live system as an RTS profile.",
    "cwd": "Change the working directory in the tree.",
    "deact": "Deactivate components: Active to Inactive.",
    "del": "Remove names from the tree.",
    "dis": "Remove connections.",
    "doc": "Write a page about a component.",
    "doctor": "Tell what is wrong with this set-up, and what helps.",
    "exit": "Finalise a component and end it.",
    "find": "Search the tree.",
    "fsm": "Look at and change the state machine of a component.",
    "get": "Print the values of live properties.",
    "inject": "Write values into ports.",
    "listen": "Print live properties as they change.",
    "log": "Record what comes out of ports, and play it again.",
    "ls": "List directories, managers and components of the tree.",
    "mgr": "Start, stop and command managers.",
    "plan": "Show the cheapest plan from the live system to an RTS profile.",
    "print": "Print the values that come out of ports.",
    "profile": "Check, show, compare and convert profiles.",
    "proxy": "Open another endpoint, on another wire, to live properties.",
    "pwd": "Print the working directory in the tree.",
    "reset": "Reset components: Error to Inactive.",
    "resurrect": "Bring up the system of an RTS profile.",
    "serve": "Serve a Python object as live properties.",
    "set": "Set a live property.",
    "start": "Activate every component of an RTS profile.",
    "state": "Show in which of its states a system is, or lead it to another.",
    "stodot": "Write the system of an RTS profile as a graph for Graphviz.",
    "stop": "Deactivate every component of an RTS profile.",
    "teardown": "Remove every connection of an RTS profile.",
    "top": "Show what components do, live.",
    "vlog": "Print what components log.",
    "wait": "Wait for components, their states, and data of ports.",
    "watch": "Print what happens to components, as it happens.",
}
SHELL_INIT = "shell-init"
COMPLETE = "complete"
HELP = "help"
WORDS: dict[str, str] = {
    COMPLETE: "Tell a shell how a line may go on.",
    HELP: "Tell about a topic, or a verb.",
    SHELL_INIT: "Print the functions that a shell needs.",
}
"""Verbs that are no commands of their own."""
