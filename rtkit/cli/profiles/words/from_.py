"""``rtprofile from``: the RTC profile of a component that exists as code."""

from __future__ import annotations

import os

import click

from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, flag, option
from rtkit.errors import UsageProblem
from rtkit.profile.forms import FORMS, form_of_name

_EPOCH = "SOURCE_DATE_EPOCH"


@command(
    "from",
    is_local=True,
    examples=(
        ("rtprofile from Robot.py -o RTC.xml", "The profile of a component, from its code."),
        ("rtprofile from Robot.py --to yaml", "As YAML, on stdout."),
    ),
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
    from rtkit.cli.profiles.factory import component_class, instance_of
    from rtkit.component.base import Component
    from rtkit.deployment.extension import MODULE
    from rtkit.link.atomic import write_output
    from rtkit.profile.write import write_profile

    offer = component_class(modules[0], wanted)
    initialize = initialize or offer.cls.is_made_late
    _warn_of_absences(app, offer.file)
    component = instance_of(offer.cls, modules[0], is_initialised=initialize)
    if not initialize and offer.cls.on_initialize is not Component.on_initialize:
        app.verbose("ports that on_initialize makes are not told: --initialize calls it")
    module = f"{os.path.basename(offer.file)}:{offer.init}"
    profile = profile_of(component, _now(), {MODULE: module} if offer.init else {})
    write_output(write_profile(profile, form), output)


def _warn_of_absences(app: App, file: str) -> None:
    """Warn of what an old component uses that is not there, before it runs into it."""
    from rtkit.openrtm.source import MARK

    with open(file, "rb") as stream:
        source = stream.read()
    if MARK in source:
        from rtkit.openrtm.absences import absences_in  # native components have none

        app.warn(
            f"{file}:{line}: {name} of OpenRTM-aist is not supported by rtkit"
            for line, name in absences_in(source, file)
        )


def _now() -> str:
    """Return the present time, or the one that reproducible builds set."""
    import time

    epoch = os.environ.get(_EPOCH, "")
    moment = int(epoch) if epoch.isascii() and epoch.isdigit() else time.time()
    return time.strftime("%Y-%m-%dT%H:%M:%S", time.gmtime(moment))
