"""``rttype``: list and show types of ports, and find the ports that carry one."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from rtkit.cli.data.arguments import MODULES
from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App, WrongArguments, no_such
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, flag, json_flag, several
from rtkit.errors import RtkitError

if TYPE_CHECKING:
    from rtkit.deployment.facts import ComponentFacts
    from rtkit.probe.type_catalogue import CataloguedType, TypeCatalogue

_LIST, _SHOW, _PORTS = "list", "show", "find-ports"
_WORDS = (_LIST, _SHOW, _PORTS)
_IDL = ".idl"


@command(
    "rttype",
    examples=(
        ("rttype list", "All types that are known here, and the source of each."),
        ("rttype show TimedPose2D", "The IDL of a type, its size, and a value to copy."),
        ("rttype find-ports RTC::TimedLong", "The live ports that carry it."),
        ("rttype list -q 'Robot::*'", "Only names, of those that match."),
        ("rttype show -f run.mcap RTC::TimedPose2D", "A type that a recording has."),
    ),
    json=("known-type", "data-type", "typed-port"),
    arguments=("words", "data-type"),
    words=_WORDS,
    statuses={"1": "There is no such type, or a manager or a file could not be read."},
)
def main(
    app: App,
    modules: tuple[str, ...] = MODULES,
    folders: tuple[str, ...] = several("-p --path DIR", "Look for modules and IDL files here too."),
    files: tuple[str, ...] = several("-f --file FILE", "Types of this IDL file or recording, too."),
    is_quiet: bool = flag("-q --quiet", "Print only names of types, or paths of ports."),
    is_json: bool = json_flag(),
    words: tuple[str, ...] = arguments("list|show|find-ports [TYPE]"),
) -> int:
    r"""List and show types of ports, and find the ports that carry one.

    \b
    rttype list [PATTERN]...    types, each with its kind, its source, and how many live ports
                                carry it
    rttype show TYPE...         IDL; in comments its source, its size in CDR, and a value as
                                rtinject -c takes it
    rttype find-ports TYPE...   in and out ports of all managers of this host, and service
                                ports that provide or require an interface

    TYPE is RTC::TimedLong, IDL:RTC/TimedLong:1.0, or TimedLong where that is clear; a PATTERN has
    * and ?. Known are the types of the standard, those that live ports tell, those of files
    *.idl in this folder, in its folder idl, in those of -p and where managers look for modules, of
    modules (-m) and of recordings. Where two of them differ, -m and -f take precedence, then live
    ports; rttype show tells of the others.
    """
    if not words or words[0] not in _WORDS:
        raise WrongArguments(no_such("word", words[0], _WORDS) if words else "No word specified.")
    word, *typed = words
    if word != _LIST and not typed:
        raise WrongArguments("No type specified.")
    catalogue, status = _catalogue(app, modules, folders, files)
    if word == _LIST:
        _list(catalogue, typed, is_quiet, is_json)
    for each in typed if word != _LIST else ():
        if word == _SHOW:
            _show(app, catalogue, each, is_quiet, is_json)
        else:
            _find_ports(catalogue, each, is_quiet, is_json)
    return status


def _catalogue(
    app: App, modules: Sequence[str], folders: Sequence[str], files: Sequence[str]
) -> tuple[TypeCatalogue, int]:
    """Return what is known, and the exit status: 1 where somebody or a file could not be asked."""
    from rtkit.probe.known_types import import_modules
    from rtkit.probe.type_catalogue import TypeCatalogue
    from rtkit.recording.mcap_file import RecordingReader

    catalogue = TypeCatalogue()
    import_modules(modules, folders)
    catalogue.add_modules(modules)
    for file in files:
        if file.lower().endswith(_IDL):
            _read_idl(catalogue, file)
        else:
            catalogue.add_recording(file, RecordingReader(file).info().channels)
    status = 0
    for error in _ask_managers(app, catalogue):
        app.fail(str(error))
        status = app.status(error)
    for file in _idl_files(folders):
        try:
            _read_idl(catalogue, file)
        except (RtkitError, OSError) as error:
            app.fail(f"warning: {error}")
    catalogue.add_standard()
    return catalogue, status


def _read_idl(catalogue: TypeCatalogue, file: str) -> None:
    """Add the types of an IDL file; what it includes is looked for beside it.

    Raises:
        InvalidDocument: It is no IDL; names the line.
        OSError: It cannot be read.
    """
    from rtkit.idl.read import read_idl

    def find(name: str, including: str) -> tuple[str, str] | None:
        path = os.path.join(os.path.dirname(including), name)
        return (path, _text(path)) if os.path.isfile(path) else None

    catalogue.add_idl(file, read_idl(_text(file), file, find))


def _text(path: str) -> str:
    with open(path, encoding="utf-8", errors="replace") as file:
        return file.read()


def _idl_files(folders: Sequence[str]) -> list[str]:
    places = os.environ.get("RTKIT_MODULE_PATH", "").split(os.pathsep)
    found: dict[str, str] = {}
    for folder in (".", "idl", *folders, *filter(None, places)):
        if os.path.isdir(folder):
            for name in sorted(os.listdir(folder)):
                path = os.path.normpath(os.path.join(folder, name))
                if name.lower().endswith(_IDL) and os.path.isfile(path):
                    found.setdefault(os.path.realpath(path), path)
    return list(found.values())


def _ask_managers(app: App, catalogue: TypeCatalogue) -> Iterator[RtkitError]:
    """Add the types of live ports; yield the errors of managers that do not answer."""
    from rtkit.api.gathering import snapshots

    if not app.finds_managers:
        catalogue.add_live(_placed(app.tree.snapshot().components, app.tree.manager, app.tree.host))
        return
    for name, snapshot in snapshots(app):
        if isinstance(snapshot, RtkitError):
            yield snapshot
        else:
            catalogue.add_live(_placed(snapshot.components, name, snapshot.host))


def _placed(
    components: Sequence[ComponentFacts], manager: str, host: str
) -> list[tuple[str, ComponentFacts]]:
    """Return living components, but those of data tools, each behind its path."""
    from rtkit.api.observers import place_of
    from rtkit.link.places import usual_manager

    is_usual = manager == usual_manager()
    return [
        (place_of(manager, each, host, is_usual=is_usual), each)
        for each in components
        if not each.zombie and not each.is_tool
    ]


def _list(catalogue: TypeCatalogue, patterns: Sequence[str], is_quiet: bool, is_json: bool) -> None:
    from rtkit.rtc.names import glob

    wanted = [glob(each) for each in patterns]
    counts = catalogue.counts()
    found = sorted(catalogue.types, key=lambda each: each.name)
    if wanted:
        names = {each: (each.name, each.name.rpartition("::")[2]) for each in found}
        found = [e for e in found if any(p.fullmatch(n) for p in wanted for n in names[e])]
    if is_json:
        records = (
            {**json_records.picked(each, "type=name kind source"), "ports": counts[each.name]}
            for each in found
        )
        terminal.write(json_records.lines("known-type", records))
    elif is_quiet:
        terminal.write(map(terminal.printable, dict.fromkeys(each.name for each in found)))
    elif found:
        terminal.write(terminal.table([_row(each, counts[each.name]) for each in found]))


def _row(each: CataloguedType, ports: int) -> list[str]:
    return [each.name, each.kind, each.source, f"{ports} port{'s' * (ports != 1)}" if ports else ""]


def _show(app: App, catalogue: TypeCatalogue, typed: str, is_quiet: bool, is_json: bool) -> None:
    from rtkit.probe.type_catalogue import lines_of, page_of

    first, *others = catalogue.find(typed)
    if is_quiet:
        terminal.write([terminal.printable(first.name)])
        return
    page = page_of(first)
    for other in others:
        if page_of(other).definition not in ("", page.definition):
            app.fail(f"warning: {first.name} is another one in {other.source}")
    paths = [each.path for each in catalogue.ports if each.type_name == first.name]
    if not is_json:
        more = f" and {len(paths) - 1} more" if len(paths) > 1 else ""
        at = f": {paths[0]}{more}" if paths and first.source == "live" else ""
        terminal.write(map(terminal.printable, lines_of(page, f"{first.source}{at}")))
        return
    fields = [dict(zip(("name", "type", "about"), each, strict=True)) for each in page.fields]
    record = {
        "type": first.name,
        "kind": first.kind,
        "source": first.source,
        "ports": paths,
        "definition": page.definition or None,
        "fields": fields,
        "size_bytes": page.size_bytes,
        "is_fixed_size": page.is_fixed,
        "example": page.example,
    }
    terminal.write([json_records.line("data-type", record)])


def _find_ports(catalogue: TypeCatalogue, typed: str, is_quiet: bool, is_json: bool) -> None:
    name = catalogue.find(typed)[0].name
    found = [each for each in catalogue.ports if each.type_name == name]
    if is_json:
        picked = (json_records.picked(each, "path direction type=type_name") for each in found)
        terminal.write(json_records.lines("typed-port", picked))
    elif is_quiet:
        terminal.write(terminal.printable(each.path) for each in found)
    elif found:
        terminal.write(terminal.table([(each.path, each.direction) for each in found]))
