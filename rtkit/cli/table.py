"""Lists commands, each with its module and summary; written by "make commands"."""

TABLE: dict[str, tuple[str, str]] = {
    "rtact": ("rtkit.cli.components.rtact", "Activate components: Inactive to Active."),
    "rtapply": ("rtkit.cli.system.rtapply", "Make the live system what an RTS profile says."),
    "rtbuild": ("rtkit.cli.profiles.rtbuild", "Generate a component from its RTC profile."),
    "rtcat": ("rtkit.cli.tree.rtcat", "Describe a component, a port or a manager."),
    "rtcheck": ("rtkit.cli.system.rtcheck", "Compare the live system with an RTS profile."),
    "rtcomp": ("rtkit.cli.components.rtcomp", "Make and change composite components."),
    "rtcon": ("rtkit.cli.components.rtcon", "Connect the first port to each of the others."),
    "rtconf": (
        "rtkit.cli.components.rtconf",
        "Show and change the configuration sets of a component.",
    ),
    "rtcryo": ("rtkit.cli.system.rtcryo", "Save the live system as an RTS profile."),
    "rtcwd": ("rtkit.cli.tree.rtcwd", "Change the working directory in the tree."),
    "rtdeact": ("rtkit.cli.components.rtdeact", "Deactivate components: Active to Inactive."),
    "rtdel": ("rtkit.cli.tree.rtdel", "Remove names from the tree."),
    "rtdis": ("rtkit.cli.components.rtdis", "Remove connections."),
    "rtdoc": ("rtkit.cli.profiles.rtdoc", "Write a page about a component."),
    "rtdoctor": (
        "rtkit.cli.managers.rtdoctor",
        "Tell what is wrong with this set-up, and what helps.",
    ),
    "rtexit": ("rtkit.cli.components.rtexit", "Finalise a component and end it."),
    "rtfind": ("rtkit.cli.tree.rtfind", "Search the tree."),
    "rtfsm": ("rtkit.cli.components.rtfsm", "Look at and change the state machine of a component."),
    "rtget": ("rtkit.cli.properties.rtget", "Print the values of live properties, a line each."),
    "rtinject": ("rtkit.cli.data.rtinject", "Write values into ports."),
    "rtlisten": ("rtkit.cli.properties.rtlisten", "Print live properties as they change."),
    "rtlog": (
        "rtkit.cli.data.rtlog",
        "Record what comes out of ports, and play it again into others.",
    ),
    "rtls": ("rtkit.cli.tree.rtls", "List directories, managers and components of the tree."),
    "rtmgr": ("rtkit.cli.managers.rtmgr", "Start, stop and command managers."),
    "rtplan": (
        "rtkit.cli.system.rtplan",
        "Show the cheapest plan from the live system to an RTS profile.",
    ),
    "rtprint": ("rtkit.cli.data.rtprint", "Print the values that come out of ports, as they come."),
    "rtprofile": ("rtkit.cli.profiles.rtprofile", "Check, show, compare and convert profiles."),
    "rtproxy": (
        "rtkit.cli.properties.rtproxy",
        "Open another endpoint, on another wire, to live properties.",
    ),
    "rtpwd": ("rtkit.cli.tree.rtpwd", "Print the working directory in the tree."),
    "rtreset": ("rtkit.cli.components.rtreset", "Reset components: Error to Inactive."),
    "rtresurrect": ("rtkit.cli.system.rtresurrect", "Bring up the system of an RTS profile."),
    "rtserve": ("rtkit.cli.properties.rtserve", "Serve a Python object as live properties."),
    "rtset": ("rtkit.cli.properties.rtset", "Set a live property."),
    "rtstart": (
        "rtkit.cli.system.rtstart",
        "Activate every component of an RTS profile, in its order.",
    ),
    "rtstate": (
        "rtkit.cli.system.rtstate",
        "Show in which of its states a system is, or lead it to another.",
    ),
    "rtstodot": (
        "rtkit.cli.system.rtstodot",
        "Write the system of an RTS profile as a graph for Graphviz.",
    ),
    "rtstop": (
        "rtkit.cli.system.rtstop",
        "Deactivate every component of an RTS profile, in reverse order.",
    ),
    "rtteardown": ("rtkit.cli.system.rtteardown", "Remove every connection of an RTS profile."),
    "rttop": ("rtkit.cli.observing.rttop", "Show what components do, live."),
    "rtvlog": ("rtkit.cli.observing.rtvlog", "Print what components log."),
    "rtwait": (
        "rtkit.cli.observing.rtwait",
        "Wait for components, their states, and data of ports.",
    ),
    "rtwatch": ("rtkit.cli.observing.rtwatch", "Print what happens to components, as it happens."),
    "rtprofile validate": (
        "rtkit.cli.profiles.words.validate",
        "Check profiles against the schemas, and against what no schema can tell.",
    ),
    "rtprofile check": (
        "rtkit.cli.profiles.words.check",
        "Check systems against the RTC profiles of their components; nothing is run.",
    ),
    "rtprofile show": ("rtkit.cli.profiles.words.show", "Show what a profile says."),
    "rtprofile diff": ("rtkit.cli.profiles.words.diff", "Compare two profiles by what they mean."),
    "rtprofile convert": (
        "rtkit.cli.profiles.words.convert",
        "Write a profile as XML, YAML or JSON.",
    ),
    "rtprofile normalise": (
        "rtkit.cli.profiles.words.normalise",
        "Bring profiles to the strict form, and tell each repair.",
    ),
    "rtprofile set": (
        "rtkit.cli.profiles.words.set",
        "Set properties of a system and its components, in its profile.",
    ),
    "rtprofile new": (
        "rtkit.cli.profiles.words.new",
        "Begin the profile of a component or of a system.",
    ),
    "rtprofile from": (
        "rtkit.cli.profiles.words.from_component",
        "Write the RTC profile of a component, from its code.",
    ),
    "rtprofile doc": (
        "rtkit.cli.profiles.words.doc",
        "Write a page about a component, or a system, from what its profile documents.",
    ),
    "rtprofile graph": (
        "rtkit.cli.profiles.words.graph",
        "Draw a system, or a component type, without running it.",
    ),
}
