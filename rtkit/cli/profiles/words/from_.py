"""``rtprofile from``: the RTC profile of a component that exists as code."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

from rtkit.cli.shared import json_records, terminal
from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, flag, json_flag, option
from rtkit.errors import UsageProblem
from rtkit.profile.forms import FORMS, form_of_name

if TYPE_CHECKING:
    from rtkit.modules.search import ModuleSource
    from rtkit.openrtm.loading.absences import AbsentUse

_EPOCH = "SOURCE_DATE_EPOCH"


@command(
    "from",
    is_local=True,
    examples=(
        ("rtprofile from Robot.py -o RTC.xml", "The profile of a component, from its code."),
        ("rtprofile from Robot.py --to yaml", "As YAML, on stdout."),
        (
            "rtprofile from --json ConsoleIn.py",
            "Names of OpenRTM that are not there.",
        ),
    ),
    json=("absent-name",),
    arguments=("module",),
)
def main(
    app: App,
    output: str = option("-o --output FILE", "Where to write (- is stdout).", default="-"),
    to: str | None = option(
        "--to", "What to write; else as FILE ends, else XML.", click.Choice(FORMS)
    ),
    wanted: str = option("--type", "Which type, of a module that offers several.", default=""),
    initialize: bool = flag(
        "--initialize", "Call on_initialize first, for ports that are made there."
    ),
    is_json: bool = json_flag(
        "A record for each name of OpenRTM that is not there, and no profile: no code runs."
    ),
    modules: tuple[str, ...] = arguments("MODULE:FACTORY"),
) -> None:
    """Write the RTC profile of a component, from its code.

    MODULE is a file, or a name in the places where managers look for modules; FACTORY is its init
    function, by default NAMEInit, or the class of a component. The module is imported and an
    instance is made of it: its code runs. Everything that rtbuild puts into code is found again.
    Of a component written for OpenRTM-aist onInitialize is called, too; what it uses of OpenRTM
    and rtkit does not have is told before, with its line.
    """
    if len(modules) != 1:
        raise WrongArguments("One MODULE:FACTORY has to be given.")
    form = to or form_of_name(output) or FORMS[0]
    if output != "-" and to is None and form_of_name(output) is None:
        raise UsageProblem(f"no form to write: --to {'|'.join(FORMS)}, or a FILE that ends so")
    from rtkit.builder.profile_of import profile_of
    from rtkit.cli.profiles.factory import component_class, instance_of, module_source
    from rtkit.component.base import Component
    from rtkit.deployment.extension import MODULE
    from rtkit.link.atomic import write_output
    from rtkit.profile.write import write_profile

    source = module_source(modules[0])
    absences = _absences(source)
    if is_json:
        terminal.write(_record(source.file, each) for each in absences)
        return
    app.warn(
        f"{source.file}:{line}: {name} of OpenRTM-aist is not supported by rtkit"
        for line, name in absences
    )
    offer = component_class(modules[0], wanted)
    initialize = initialize or offer.cls.is_made_late
    component = instance_of(offer.cls, modules[0], is_initialised=initialize)
    if not initialize and offer.cls.on_initialize is not Component.on_initialize:
        app.verbose("ports that on_initialize makes are not told: --initialize calls it")
    module = f"{os.path.basename(offer.file)}:{offer.init}"
    profile = profile_of(component, _now(), {MODULE: module} if offer.init else {})
    write_output(write_profile(profile, form), output)


def _absences(source: ModuleSource) -> Sequence[AbsentUse]:
    """Return what an old component uses that is not there; native ones have none."""
    from rtkit.openrtm.migrate.source import MARK

    if MARK not in source.text:
        return ()
    from rtkit.openrtm.loading.absences import absences_in

    return absences_in(source.text, source.file)


def _record(file: str, use: AbsentUse) -> str:
    return json_records.line("absent-name", {"file": file, "line": use.line, "name": use.name})


def _now() -> str:
    """Return the present time, or the one that reproducible builds set."""
    import time

    epoch = os.environ.get(_EPOCH, "")
    moment = int(epoch) if epoch.isascii() and epoch.isdigit() else time.time()
    return time.strftime("%Y-%m-%dT%H:%M:%S", time.gmtime(moment))
