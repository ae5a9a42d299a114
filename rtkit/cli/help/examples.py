"""Examples of the manual pages: command lines, each with its effect."""

from __future__ import annotations

EXAMPLES: dict[str, tuple[tuple[str, str], ...]] = {
    "rtact": (
        ("rtact /localhost/Robot0.rtc", "Activate one component and wait until it is active."),
        ("rtact -e all /localhost/Robot0.rtc", "In all of its execution contexts."),
        ("rtact A.rtc B.rtc C.rtc", "Several at once, below the working directory of the tree."),
    ),
    "rtapply": (
        ("rtapply robot.xml", "Create, connect, set and activate just what is not so yet."),
        ("rtapply --rollback robot.xml", "Come back to what was before if a step fails."),
        ("rtapply -s inactive --parallel 4 robot.xml", "Activate nothing, at most four at once."),
    ),
    "rtbuild": (
        ("rtbuild RTC.xml", "Generate a component beside its profile; again after each change."),
        ("rtbuild robot.yaml -o robot -I idl", "In a folder of its own, with IDL files of idl."),
        ("rtbuild --dry-run RTC.xml", "What would be written."),
        ("rtbuild MyService.idl -o src", "Only the types and protocols of an IDL file."),
    ),
    "rtcat": (
        ("rtcat /localhost/Robot0.rtc", "Identity, state and ports of a component."),
        ("rtcat -ll /localhost/Robot0.rtc:velocity", "A port with all of its connections."),
        ("rtcat /localhost/manager.mgr", "A manager and the modules that it loaded."),
    ),
    "rtcheck": (
        ("rtcheck robot.xml", "Is everything there, connected, configured and active?"),
        ("rtcheck --diff robot.xml", "What the profile says, and what lives instead."),
        ("rtcheck -s inactive --json robot.xml", "Each deviation as JSON, for another program."),
    ),
    "rtcomp": (
        (
            "rtcomp -a Sensor0.rtc:range -a Control0.rtc /localhost/manager.mgr:Robot0",
            "Make a composite of two components that shows a port of the first.",
        ),
        ("rtcomp -a Control0.rtc:speed Robot0.rtc", "Show another port."),
        ("rtcomp -r Sensor0.rtc Robot0.rtc", "Let a member go, with the ports shown of it."),
        (
            "rtcomp -t GroupingComposite -a Left.rtc -a Right.rtc /localhost/manager.mgr:Wheels",
            "Only group components: each keeps its own execution context.",
        ),
    ),
    "rtcon": (
        (
            "rtcon /localhost/Sensor0.rtc:range /localhost/Control0.rtc:range",
            "Connect an out port to an in port.",
        ),
        (
            "rtcon -p dataport.subscription_type=flush Sensor0.rtc:range Control0.rtc:range",
            "Have values sent within the writer's call.",
        ),
        (
            "rtcon -d -i range Sensor0.rtc:range Control0.rtc:range",
            "With an id of one's own, and never twice.",
        ),
    ),
    "rtconf": (
        ("rtconf -l /localhost/Robot0.rtc", "All configuration sets with their values."),
        ("rtconf /localhost/Robot0.rtc get speed", "The value of a parameter of the active set."),
        ("rtconf /localhost/Robot0.rtc set speed=0.5 turn=-0.1", "Two changes, both or none."),
        ("rtconf /localhost/Robot0.rtc diff careful", "Where the active set differs from another."),
        ("rtconf /localhost/Robot0.rtc export robot.json", "Write the sets to a file."),
        ("rtconf /localhost/Robot1.rtc import robot.json", "Take them over, here or elsewhere."),
        ("rtconf -s careful /localhost/Robot0.rtc act", "Make another set the active one."),
    ),
    "rtcryo": (
        ("rtcryo -n Robot -o robot.xml", "Save what is running."),
        ("rtcryo --all", "Also components without connections, on stdout."),
    ),
    "rtcwd": (
        ("rtcwd /localhost/robot.host_cxt", "Print the line that a shell is to evaluate."),
        ("rtcwd ..", "One level up. What the shell function does, and rtkit shell-init defines."),
    ),
    "rtdeact": (("rtdeact /localhost/Robot0.rtc", "Stop a component from executing."),),
    "rtdel": (
        ("rtdel -z", "Remove everything that nobody is behind any more."),
        ("rtdel /localhost/old.host_cxt", "Remove a directory, that is every name in it."),
        ("rtdel -z /localhost/Robot0.rtc", "Remove a name, but only if it is a zombie's."),
    ),
    "rtdis": (
        ("rtdis /localhost/Robot0.rtc", "Remove every connection of a component."),
        ("rtdis -i range /localhost/Sensor0.rtc:range", "Only the one of that id."),
        ("rtdis Sensor0.rtc:range Control0.rtc:range", "Those between two ports."),
    ),
    "rtdoc": (
        ("rtdoc /localhost/Robot0.rtc > Robot0.html", "A page about a live component."),
        ("rtdoc -f markdown -o Robot.md Robot.py", "About a module that nobody has loaded."),
    ),
    "rtdoctor": (
        ("rtdoctor", "What is wrong, and what helps?"),
        ("rtdoctor --strict --json", "In a script: warnings fail too."),
    ),
    "rtexit": (
        ("rtexit /localhost/Robot0.rtc", "End a component; its name goes with it."),
        ("rtexit --force /localhost/Robot0.rtc", "End it though it hangs, with its slave."),
        ("rtexit /localhost/manager.mgr/arm.mgr", "End a slave with all that it holds."),
    ),
    "rtfind": (
        ("rtfind / -t c -n 'Motor*.rtc'", "All components whose name begins with Motor."),
        ("rtfind /localhost -t z", "All zombies of this host."),
        ("rtfind . -m 1 -i 'motor?.rtc'", "In this directory, capitals or not."),
    ),
    "rtfsm": (
        ("rtfsm /localhost/Microwave0.rtc getstate", "Print the present state."),
        ("rtfsm Microwave0.rtc seteventprofiles open:TimedLong,close:TimedLong", "Other events."),
        ("rtfsm Microwave0.rtc setstructure microwave.scxml", "Other states and transitions."),
    ),
    "rtget": (
        ("rtget robot", "The names that a service has."),
        ("rtget robot.speed robot.location.x", "Two values, a line each."),
        (
            "rtget /localhost/Motor0.rtc.state",
            "Of a component; also of managers, and localhost.load.",
        ),
        ("rtget -p values -p names='(speed mode)' robot", "Several names with their values."),
        ("rtget robot.speed.meta", "Type, unit, range, time, quality of a property."),
        ("rtget --raw robot.image > image.jpg", "Bytes, as they are."),
    ),
    "rtkit": (
        ("rtkit ls /localhost", "The same as rtls /localhost."),
        ("rtkit conf -h", "Tell about one verb."),
        ("rtkit shell-init bash", "What bash evaluates to know rtcwd."),
    ),
    "rtinject": (
        ("rtinject -c 42 Robot0.rtc:speed", "One value, and wait until it has arrived."),
        ("rtinject -c '{vx: 0.5}' -r 10 -t 1 Robot0.rtc:velocity", "Ten a second for 1 s."),
        ("rtinject --lossless Robot0.rtc:way < points.jsonl", "Each line of a file."),
    ),
    "rtlisten": (
        ("rtlisten robot.speed", "Every change, until Ctrl-C."),
        ("rtlisten -n 1 --every 0.5 robot.location", "At most two a second, and only one."),
        ("rtlisten /localhost/Robot0.rtc.ports.pose.count", "How much passes a port."),
        ("rtlisten --mode diff robot", "Which names come and go."),
    ),
    "rtlog": (
        ("rtlog -f run.mcap Robot0.rtc:pose", "Record every pose until Ctrl-C."),
        ("rtlog -d -f run.mcap", "What is in the recording."),
        ("rtlog --export csv -f run.mcap", "Its values for a spreadsheet, one field a line."),
        ("rtlog -p -r 0.5 -f run.mcap Map0.rtc:pose", "Play it at half its speed."),
    ),
    "rtls": (
        ("rtls -l /localhost", "State, ports and connections of what runs here."),
        ("rtls -R /", "Everything."),
        ("rtls -l --watch=0.5 /localhost", "Look again twice a second."),
        ("rtls -R --json /", "Everything, for another program."),
        ("rtls -l robot", "The properties of an object that rtserve serves."),
    ),
    "rtmgr": (
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
        ("rtmgr stop", "End the manager with everything that it holds."),
    ),
    "rtplan": (
        ("rtplan robot.xml", "What would be done, what it costs, what is kept."),
        ("rtplan --cost Motor0=1000 robot.xml", "Interrupt Motor0 only if nothing else will do."),
        ("rtplan --detailed-exitcode robot.xml", "Exit status 2 when something is to be changed."),
        ("rtplan --dot robot.xml", "What comes before what, as a graph."),
    ),
    "rtprint": (
        ("rtprint Robot0.rtc:pose", "Every value, until Ctrl-C."),
        ("rtprint -n 1 -f data.position.x Robot0.rtc:pose", "One field of the next value."),
        ("rtprint --plot Robot0.rtc:pose", "The numbers of its pose as curves."),
        ("rtprint -t 2 --json A0.rtc:out B0.rtc:out", "All values of 2 s as JSON lines."),
    ),
    "rtprofile": (
        ("rtprofile from Robot.py -o RTC.xml", "The profile of a component, from its code."),
        ("rtprofile validate robot.xml", "Is it valid, and what had to be put right?"),
        ("rtprofile validate --strict profiles systems", "Whole folders, without forgiveness."),
        ("rtprofile validate --format sarif . > found.sarif", "For a code host or an editor."),
        ("rtprofile show robot.xml", "What is in it."),
        ("rtprofile diff robot.xml robot.new.xml", "What changed, but for ids, dates, positions."),
        ("rtprofile convert robot.xml robot.yaml", "The same as YAML; also --to json."),
        ("rtprofile normalise -i *.xml", "Put right in place what can be, and tell it."),
        ("rtprofile set robot.xml Control0:rtkit.restart=on-failure", "Restart it when it fails."),
        (
            "rtprofile new component Motor --in speed:TimedDouble --parameter 'gain:double=1.0'",
            "Begin Motor.xml.",
        ),
        (
            "rtprofile new system Robot --component Motor.xml:Left --component Eye.xml "
            "--connect Eye0.speed=Left.speed",
            "Begin Robot.xml.",
        ),
        ("rtprofile doc Motor.xml -o Motor.html", "A page about a component, in one file."),
        ("rtprofile graph robot.xml -o robot.svg", "A picture of a system."),
    ),
    "rtproxy": (
        ("rtproxy robots/arm tcp:4711", "Read-only, for clients that know the user's secret."),
        ("rtproxy robots/arm unix:arm.sock --allow-set 'angle*'", "Some of it may be set."),
        (
            "rtproxy tcp:localhost:4711/robots/arm far/arm --prefix left",
            "From a TCP endpoint back into the tree, all names below left.",
        ),
        ("rtproxy /localhost/Motor0.rtc tcp:4712 --allow-set state", "A component."),
        (
            "rtproxy robots/arm mqtt:robot@localhost/lab",
            "At an MQTT broker, in the style of Homie.",
        ),
    ),
    "rtpwd": (("rtpwd", "Print where relative paths start from."),),
    "rtreset": (("rtreset /localhost/Robot0.rtc", "Bring a component out of Error."),),
    "rtresurrect": (
        ("rtresurrect robot.xml", "Make, configure and connect what a profile describes."),
        ("rtresurrect --dry-run robot.xml", "Tell what would be done."),
        ("rtresurrect --stand-in robot.xml", "Without the modules: stand-ins for components."),
    ),
    "rtserve": (
        ("rtserve simple_pid:PID pid -a 1 -a 0.1", "A class, called with two arguments."),
        ("rtserve ./arm.py:Arm robots/arm --port 0", "Of a file, with a TCP endpoint too."),
        (
            "rtserve ./arm.py:Arm arm --serial /dev/ttyS0 --allow-set 'angle*'",
            "With a serial line, over which the angles may be set.",
        ),
        ("rtserve ./arm.py:Arm robots/arm --http 8080", "For curl and browsers too."),
        ("rtserve ./arm.py:Arm arm --history 'angle=100'", "Remember values for .history."),
        ("rtserve ./arm.py:Arm arm --rule 'deny zenoh * SET *'", "Read-only over zenoh."),
    ),
    "rtset": (
        ("rtset robot.speed -0.5", "A number."),
        ("rtset robot.location.x 3", "A part of a vector."),
        ("rtset --echo robot.double 21", "An action: wait, and print what came of it."),
        ("rtset --if 7 robot.mode drive", "Only if nobody has changed it since."),
        ("rtset robot properties '((speed 0) (mode idle))'", "Several, all or none."),
        ("rtset /localhost/Motor0.rtc.state Active", "Of a component: it is activated."),
        ("rtset --file image.jpg robot.image", "The content of a file."),
    ),
    "rtstart": (
        ("rtstart robot.xml", "Activate the components of a profile in its order."),
        ("rtstart --dry-run robot.xml", "Tell in which order, and what each waits for."),
        ("rtstart --plan robot.xml > robot.dot", "The same as a graph, for Graphviz."),
    ),
    "rtstate": (
        ("rtstate robot.xml", "Which state it is in, the way to each other, the events."),
        ("rtstate --goto dock robot.xml", "Lead it there, by the cheapest plan."),
        ("rtstate --event start robot.xml", "Lead it where this event leads."),
        ("rtstate --follow robot.xml", "Have its manager lead it on by events; watch."),
        ("rtstate --unfollow Robot", "Let its manager follow it no more."),
    ),
    "rtstodot": (
        ("rtstodot robot.xml > robot.dot", "The graph of a system; dot -Tsvg draws it."),
        ("rtcryo | rtstodot", "Of what is saved now; rtstodot --live shows states too."),
    ),
    "rtstop": (("rtstop robot.xml", "Deactivate them in reverse order."),),
    "rtteardown": (
        ("rtteardown robot.xml", "Remove the connections of a profile."),
        ("rtteardown --exit robot.xml", "End its components too."),
    ),
    "rttop": (
        ("rttop", "All components of this host, live; h shows the keys."),
        ("rttop -s CPU% /localhost/manager.mgr", "Those of one manager, the busiest first."),
        ("rttop --once --json", "One look, for another program."),
    ),
    "rtvlog": (
        ("rtvlog /localhost/Robot0.rtc", "What a component logs: the last lines, then what comes."),
        ("rtvlog -l warn /", "Warnings and errors of everything."),
        ("rtvlog --no-follow -n 20 Robot0.rtc", "The last 20 records, also of a zombie."),
        ("rtvlog -f stdout /localhost/manager.mgr/drives.mgr", "What code in a slave printed."),
    ),
    "rtwait": (
        ("rtwait -t 10 Robot0.rtc active", "Until it is active, or 10 s are over."),
        ("rtwait A.rtc B.rtc active Laser0.rtc:scan data", "A and B active, and a scan came."),
    ),
    "rtwatch": (
        ("rtwatch /", "Everything that happens on this host."),
        ("rtwatch -f rtc_status Robot0.rtc Arm0.rtc", "Only states of two components."),
        ("rtwatch -n 1 -t 60 -f tree_event Robot0.rtc", "Until it goes; status 1 if it does not."),
        ("rtwatch --json / > events.jsonl", "For another program."),
    ),
}
