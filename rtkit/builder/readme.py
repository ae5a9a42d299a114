"""Generates the README of a component: description, usage, ports and parameters."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rtkit.builder.component_code import LABELS, SUMMARIES, port_doc, service_doc
from rtkit.builder.packaging import project_name
from rtkit.builder.regions import MARKDOWN_STAMP
from rtkit.builder.source_text import clean, doc_text, one_line
from rtkit.builder.subject import GeneratedComponent, GeneratedPort
from rtkit.component.contexts.owned_contexts import PERIODIC

_KINDS = {"InPort": "in", "OutPort": "out", "EventPort": "event"}
_PORT_FACTS = {
    "semantics": "",
    "number": "number: ",
    "occerrence": "occurrence: ",
    "operation": "operation: ",
}


def readme(subjects: Sequence[GeneratedComponent]) -> str:
    """Return ``README.md`` of the components of a project, not yet stamped."""
    first = subjects[0]
    if len(subjects) == 1:
        title, *parts = _parts(first, "RTC.xml", first)
        found = [title, [MARKDOWN_STAMP], *parts]
    else:
        found = [[f"# {project_name(first.type_name)}"], [MARKDOWN_STAMP]]
        found.append([f"{len(subjects)} component types in one package."])
        for each in subjects:
            profile = "RTC.xml" if each is first else f"{each.module}.xml"
            # Each is a section of its own, one level deeper.
            found += [
                [f"#{line}" if line.startswith("#") else line for line in part]
                for part in _parts(each, profile, first)
            ]
    return "\n\n".join("\n".join(part) for part in found if part) + "\n"


def _parts(subject: GeneratedComponent, profile: str, first: GeneratedComponent) -> list[list[str]]:
    return [
        [f"# {_plain(subject.type_name)}"],
        [_plain(subject.description or f"Component type {subject.type_name}.")],
        list(_documentation(subject)),
        list(_identity(subject)),
        list(_running(subject)),
        *_tables(subject),
        list(_work(subject, profile, project_name(first.type_name))),
    ]


def _plain(text: str) -> str:
    """Return text that Markdown shows as it is."""
    safe = "".join(f"\\{c}" if c in "\\`*_{}[]<>#|~" else c for c in one_line(text))
    return safe or "-"


def _code(text: str) -> str:
    """Return text as code for a cell of a table."""
    shown = "".join(c if c.isprintable() else " " for c in text).strip()
    if not shown:
        return ""
    ticks = "`"
    while ticks in shown:
        ticks += "`"
    blank = " " if "`" in shown else ""
    return f"{ticks}{blank}{shown}{blank}{ticks}".replace("|", "\\|")


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    lines = [head, ["---"] * len(head), *rows]
    return [f"| {' | '.join(row)} |" for row in lines]


def _documentation(subject: GeneratedComponent) -> Iterator[str]:
    doc = subject.info.doc
    texts = [("", doc_text(doc, "description"))]
    texts += [(label, doc_text(doc, key)) for key, label in LABELS.items()]
    first = True
    for label, text in texts:
        if clean(text):
            yield from [] if first else [""]
            first = False
            yield label + "  \n".join(_plain(line) for line in clean(text).split("\n") if line)


def _identity(subject: GeneratedComponent) -> Iterator[str]:
    info = subject.info
    facts = [("vendor", info.vendor), ("category", info.category), ("version", info.version)]
    driven = subject.execution_type
    if driven == PERIODIC and subject.rate:
        driven = f"{driven}, {subject.rate:g} Hz"
    yield from _table(
        ["", ""],
        [[name, _plain(text)] for name, text in facts if text] + [["driven by", _plain(driven)]],
    )


def _running(subject: GeneratedComponent) -> Iterator[str]:
    module, name = subject.module, subject.type_name
    yield "## Run it"
    yield ""
    yield "Beside this file:"
    yield ""
    yield "```sh"
    yield "rtmgr start"
    yield f"rtmgr /localhost/manager.mgr -l ./{module}.py:{subject.init} -c {_quoted(name)}"
    yield f"rtact {_quoted(f'/localhost/{name}0.rtc')}"
    yield f"rtcat {_quoted(f'/localhost/{name}0.rtc')}"
    yield "```"
    yield ""
    yield "Where the package is installed (`pip install .`), a manager finds it by its name:"
    yield ""
    yield "```sh"
    yield f"rtmgr /localhost/manager.mgr -c {_quoted(f'{name}?manager_name=other')}"
    yield "```"
    yield ""
    yield "`rtresurrect system.xml` brings up the sample system."


def _quoted(text: str) -> str:
    """Return a word for the shell."""
    if all((c.isalnum() and c.isascii()) or c in "_./-" for c in text):
        return text
    return "'" + text.replace("'", "'\"'\"'") + "'"


def _tables(subject: GeneratedComponent) -> Iterator[list[str]]:
    machine = subject.machine
    ports = [[_code(p.name), _KINDS[p.kind], _code(_type(p)), _port_text(p)] for p in subject.ports]
    if machine:
        ports.append([_code(machine.port), "event", "", "Events of the state machine"])
    if ports:
        yield ["## Data ports", "", *_table(["port", "", "type", ""], ports)]
    services = list(_services(subject))
    if services:
        yield ["## Service ports", "", *_table(["port", "", "interface", ""], services)]
    settings = [
        [_code(s.name), _code(str(s.default)), _code(s.constraint), _code(s.unit), _cell(s.doc)]
        for s in subject.settings
    ]
    if settings:
        head = ["parameter", "default", "limits", "unit", ""]
        yield ["## Configuration", "", *_table(head, settings)]
    moves = [
        [_code(state), _code(event), _code(target)]
        for state, moves in (machine.states.items() if machine else ())
        for event, target in moves.items()
    ]
    if moves:
        yield ["## States", "", *_table(["state", "event", "next"], moves)]
    callbacks = [
        [_code(each.name), _plain(doc_text(each.status.doc, "description") or SUMMARIES[each.name])]
        for each in subject.callbacks
    ]
    if callbacks:
        yield ["## Callbacks", "", *_table(["callback", ""], callbacks)]


def _services(subject: GeneratedComponent) -> Iterator[list[str]]:
    for service in subject.services:
        for offer in service.offers:
            kind = "provided" if offer.is_provided else "required"
            doc = _cell(service_doc(service))
            yield [_code(service.name), kind, _code(offer.type_name), doc]


def _cell(text: str) -> str:
    return _plain(text) if text else ""


def _type(port: GeneratedPort) -> str:
    return port.type_name.removeprefix("IDL:").removesuffix(":1.0").replace("/", "::")


def _port_text(port: GeneratedPort) -> str:
    facts = [("", port_doc(port))]
    facts += [(label, doc_text(port.profile.doc, name)) for name, label in _PORT_FACTS.items()]
    return "; ".join(f"{label}{_plain(text)}" for label, text in facts if one_line(text))


def _work(subject: GeneratedComponent, profile: str, project: str) -> Iterator[str]:
    yield "## Work on it"
    yield ""
    marks = f"Your code goes between the marks in `{subject.module}.py`."
    yield f"{marks} After a change to `{profile}`,"
    yield f"`rtbuild {profile}` writes what follows from it and keeps what is yours."
    yield ""
    yield "```sh"
    yield f"pip install -e '.[dev]'   # {project}"
    yield "pytest"
    yield "ruff check ."
    yield "```"
