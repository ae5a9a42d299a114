"""``rtconf``: show and change configuration sets."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rtkit.cli.shared.app import App, WrongArguments, no_such
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import (
    NumbersAreArguments,
    arguments,
    flag,
    json_flag,
    option,
    strict_option,
)
from rtkit.errors import NotFound, Refused

if TYPE_CHECKING:
    from rtkit.cli.components.conf import ConfRequest
    from rtkit.rtc.names import Path
    from rtkit.tree.view import TreeNode

FORMS = {
    "list": "list",
    "get": "get PARAM",
    "set": "set PARAM VALUE, or set PARAM=VALUE...",
    "act": "act, with -s SET",
    "add": "add SET PARAM=VALUE...",
    "copy": "copy SET NEW [PARAM=VALUE]...",
    "remove": "remove SET",
    "diff": "diff SET|FILE",
    "export": "export [FILE]",
    "import": "import [FILE]",
}


class _Numbers(NumbersAreArguments):
    behind = "set"


@command(
    "rtconf",
    cls=_Numbers,
    examples=(
        ("rtconf -l /localhost/Robot0.rtc", "All configuration sets with their values."),
        ("rtconf /localhost/Robot0.rtc get speed", "The value of a parameter of the active set."),
        ("rtconf /localhost/Robot0.rtc set speed=0.5 turn=-0.1", "Two changes, both or none."),
        ("rtconf /localhost/Robot0.rtc diff careful", "Where the active set differs from another."),
        ("rtconf /localhost/Robot0.rtc export robot.json", "Write the sets to a file."),
        ("rtconf /localhost/Robot1.rtc import robot.json", "Take them over, here or elsewhere."),
        ("rtconf -s careful /localhost/Robot0.rtc act", "Make another set the active one."),
        ("rtconf /localhost/Robot0.rtc copy careful gentle speed=0.1", "A further set, like one."),
        ("rtconf /localhost/Robot0.rtc remove gentle", "Remove it again."),
    ),
    json=("configuration", "parameter", "configuration-difference", "properties"),
    arguments=("component|manager", "words", "conf"),
    words=FORMS,
    statuses={"1": "It could not be done; of diff: there are differences."},
)
def main(
    app: App,
    has_hidden: bool = flag("-a --all", "Include hidden sets (__name__)."),
    is_long: bool = flag("-l", "List parameters and their values."),
    set_id: str = option("-s --set SET", "Default: the active set.", default=""),
    wait: bool = flag("--wait", "Return when the component sees it: what happens anyway"),
    is_json: bool = json_flag("For list, get and diff: JSON objects."),
    strict: None = strict_option("Refuse to set what has no effect."),
    words: tuple[str, ...] = arguments("PATH [WORD] [ARGUMENT]..."),
) -> int:
    r"""Show and change the configuration sets of a component.

    \b
    list               the sets; the active one has a * (this is what happens without a word)
    get PARAM          the value of a parameter
    set PARAM VALUE    change one parameter
    set A=1 B=2 ...    change several, all or none
    act                make the set given with -s the active one
    add SET A=1 ...    add a set with these parameters
    copy SET NEW A=1   add a set that is like another one, but for these parameters
    remove SET         remove a set that was added and is not the active one
    diff SET|FILE      where it differs from another set, or from what was exported
    export [FILE]      write the sets as JSON
    import [FILE]      take over what was exported; sets that are not there are added

    A change of the active set takes effect at once, and one that does not fit the parameter's
    type or constraint is refused. Of a manager, list, get and set mean its properties. A value
    that begins with a minus and is no number needs -- before the path.
    """
    from rtkit.cli.components import conf
    from rtkit.tree.view import NodeKind

    typed, asked = _asked(words, has_hidden, is_long, set_id, is_json)
    path = app.path(typed)
    node = app.node(_node, path)
    snapshot = app.tree.part([node.instance])
    if node.kind is NodeKind.MANAGER:
        conf.of_manager(app, snapshot.properties, path, asked)
        return 0
    facts = snapshot.component(node.instance)
    if facts is None:
        raise NotFound(f"No such object: {path.typed}")
    return conf.of_component(app, facts, asked)


def _asked(
    words: Sequence[str], has_hidden: bool, is_long: bool, set_id: str, is_json: bool
) -> tuple[str, ConfRequest]:
    from rtkit.cli.components.conf import ConfRequest

    if not words:
        raise WrongArguments("No component specified.")
    typed, *rest = words
    verb, *arguments = rest or ["list"]
    count = len(arguments)
    is_fit = {
        "list": count == 0,
        "get": count == 1,
        "set": count == 2 or bool(count and all("=" in each[1:] for each in arguments)),
        "act": count == 0 and bool(set_id),
        "add": count > 1 and not set_id,
        "copy": count > 1 and not set_id,
        "remove": count == 1 and not set_id,
        "diff": count == 1,
        "export": count < 2,
        "import": count < 2,
    }
    if verb not in is_fit:
        raise WrongArguments(no_such("word", verb, FORMS))
    if not is_fit[verb]:
        raise WrongArguments(f"expected: {FORMS[verb]}; found: {' '.join([verb, *arguments])}")
    return typed, ConfRequest(verb, tuple(arguments), set_id, has_hidden, is_long, is_json)


def _node(root: TreeNode, path: Path, hostname: str) -> TreeNode:
    from rtkit.tree.resolve import absent, find, zombie
    from rtkit.tree.view import NodeKind

    node = find(root, path, hostname)
    if path.port is not None and node is not None:
        raise Refused(f"Not a component: {path.typed}")
    if node is not None and node.kind is NodeKind.ZOMBIE and not path.is_directory:
        raise zombie(node, path)
    is_known = node is not None and node.kind in (NodeKind.COMPONENT, NodeKind.MANAGER)
    if node is None or not is_known or (path.is_directory and not node.is_directory):
        raise absent(root, path, hostname)
    return node
