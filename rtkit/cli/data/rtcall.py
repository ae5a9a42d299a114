"""``rtcall``: call an operation of a service port."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App, WrongArguments, working_directory
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import NumbersAreArguments, arguments, json_flag
from rtkit.errors import Refused

if TYPE_CHECKING:
    from rtkit.probe.calling import ProvidedOperation


@command(
    "rtcall",
    cls=NumbersAreArguments,
    examples=(
        ("rtcall Hand0.rtc:gripper.close 3.5", "Call an operation, and print its result."),
        ("rtcall Hand0.rtc:gripper", "The operations of a port, with their types."),
        ("rtcall Hand0.rtc:gripper.move '{x: 1}' FAST", "A structure, and a word of a list."),
        ("rtcall --json --timeout 1 Hand0.rtc:gripper.width", "Wait 1 s, and write JSON."),
    ),
    json=("call", "operation"),
    arguments=("operation", ""),
    statuses={"1": "It raised an exception, did not answer in time, or cannot be called."},
)
def main(
    app: App,
    is_json: bool = json_flag("One JSON object; without an operation one a line."),
    words: tuple[str, ...] = arguments("COMPONENT:PORT[.OPERATION] [ARGUMENT]..."),
) -> int:
    r"""Call an operation of a service port.

    An argument is a JSON or YAML literal of the type that the interface says; nothing of it is
    executed. A text needs no quotes, and a word of an enumeration is its name. The result is
    printed, then each out parameter behind its name. An exception that the interface declares is
    named with what it carries.

    Without an operation those of the port are listed. Where two interfaces of a port have
    operations of one name, PORT.INSTANCE.OPERATION is the one of that interface.

    While it runs a component of its own, rtcall0, is connected to the port. --timeout bounds the
    call, too.
    """
    from rtkit.probe.calling import chosen, operations_at
    from rtkit.rtc.names import parse_path

    if not words:
        raise WrongArguments("No operation specified.")
    path = parse_path(words[0], working_directory())
    if path.port is None:
        raise WrongArguments(f"No port specified: {words[0]} (it is COMPONENT:PORT.OPERATION)")
    app.note_place(path)
    operations, typed = operations_at(app.tree, path)
    if not typed and len(words) == 1:
        return _list(operations, is_json)
    operation = chosen(operations, typed)
    return _call(app, operation, operation.arguments(words[1:]), is_json)


def _list(operations: list[ProvidedOperation], is_json: bool) -> int:
    records = [
        {
            "path": f"{each.end.path}.{each.instance}.{each.operation.name}",
            "interface": each.type_name,
            "operation": each.operation.name,
            "declaration": each.operation.text,
        }
        for each in operations
    ]
    has_several = len({each.instance for each in operations}) > 1
    texts = (
        terminal.printable(f"{each.instance}: " * has_several + each.operation.text)
        for each in operations
    )
    terminal.write(json_records.lines("operation", records) if is_json else texts)
    return 0


def _call(app: App, called: ProvidedOperation, values: tuple[Any, ...], is_json: bool) -> int:
    from rtkit.component.services.defined_interface import RaisedByProvider
    from rtkit.component.values.value_text import plain

    raised: RaisedByProvider | None = None
    results: Mapping[str, Any] = {}
    try:
        results = called.call(app.tree, values, app.timeout_s)
    except RaisedByProvider as error:
        raised = error
    if not is_json:
        terminal.write(_text(name, value) for name, value in results.items() if value is not None)
    else:
        outs = {name: plain(value) for name, value in results.items() if name}
        record = {
            "path": str(called.end.path),
            "operation": called.operation.name,
            "result": plain(results.get("")),
            "out": outs,
            "raised": raised
            and {
                "name": type(raised).__name__,
                "members": {name: plain(each) for name, each in raised.members.items()},
            },
        }
        terminal.write([json_records.line("call", record)])
    if raised is None:
        return 0
    app.fail(f"{called.label} raised {type(raised).__name__}{f': {raised}' if str(raised) else ''}")
    return app.status(Refused())


def _text(name: str, value: Any) -> str:
    from rtkit.component.values.value_text import text_of

    text = value if isinstance(value, str) else text_of(value, is_full=True)
    return terminal.printable(f"{name}: {text}" if name else text)
