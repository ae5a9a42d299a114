"""``rtprofile new``: begin the profile of a component or a system."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import click

from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import NumberChoice, arguments, flag, option, several, together
from rtkit.errors import Malformed, Refused, UsageProblem

if TYPE_CHECKING:
    from rtkit.profile.rtc_model import ConfigurationParameter, RtcProfile
    from rtkit.profile.rts_model import RtsProfile
    from rtkit.profile_tools.new_system import NewMember

_KINDS = {"component": "rtc", "rtc": "rtc", "system": "rts", "rts": "rts"}
_CALLBACKS = ("onInitialize", "onActivated", "onDeactivated", "onExecute")


class ComponentOptions(NamedTuple):
    """Options for a component: its ports, parameters, callbacks, and kind."""

    ins: tuple[str, ...] = several("--in NAME:TYPE[:UNIT|:IDL]", "component: an in port.")
    outs: tuple[str, ...] = several("--out NAME:TYPE[:UNIT|:IDL]", "component: an out port.")
    provides: tuple[str, ...] = several(
        "--provides PORT:TYPE[:IDL]", "component: a provided interface."
    )
    requires: tuple[str, ...] = several(
        "--requires PORT:TYPE[:IDL]", "component: a required interface."
    )
    parameters: tuple[str, ...] = several(
        "--parameter NAME:TYPE=DEFAULT[;CONSTRAINT]", "component: a configuration parameter."
    )
    callbacks: tuple[str, ...] = several(
        "--callback NAME", "component: a callback that it implements."
    )
    category: str | None = option("--category", "component: its category (default Misc).")
    rate: float | None = option("--rate HZ", "component: rate.", NumberChoice(min=0))
    component_type: str | None = option(
        "--type",
        "component: its type (default STATIC).",
        click.Choice(("STATIC", "UNIQUE", "COMMUTATIVE")),
    )
    activity_type: str | None = option(
        "--activity",
        "component: what drives it (default PERIODIC).",
        click.Choice(("PERIODIC", "SPORADIC", "EVENTDRIVEN")),
    )
    max_instances: int | None = option(
        "--max-instances", "component: 0 is no limit (default).", click.IntRange(min=0)
    )
    language: str | None = option("--language", "component: its language (default Python).")


class SystemOptions(NamedTuple):
    """Options for a system: its components and connections."""

    members: tuple[str, ...] = several(
        "--component FILE[:INSTANCE]", "system: a component, by its profile."
    )
    connections: tuple[str, ...] = several(
        "--connect INSTANCE.PORT=INSTANCE.PORT", "system: a connection."
    )
    slaves: tuple[str, ...] = several(
        "--slave INSTANCE=SLAVE", "system: the slave that holds a component (default none)."
    )
    host: str | None = option("--host", "system: where its components are (default localhost).")


@command(
    "new",
    is_local=True,
    examples=(
        (
            "rtprofile new component Motor --in speed:TimedDouble --parameter 'gain:double=1.0'",
            "Begin Motor.xml.",
        ),
        (
            "rtprofile new system Robot --component Motor.xml:Left --component Eye.xml "
            "--connect Eye0.speed=Left.speed",
            "Begin Robot.xml.",
        ),
    ),
    arguments=("component-or-system",),
)
def main(
    app: App,
    output: str | None = option("-o --output FILE", "Where to write it (default NAME.xml)."),
    force: bool = flag("-f --force", "Replace what is there."),
    vendor: str = option("--vendor", "Who made it (default Me).", default="Me"),
    release: str = option("--release", "Version of it (default 1.0.0).", default="1.0.0"),
    description: str = option("--description", "What it is.", default=""),
    component: ComponentOptions = together(ComponentOptions),
    system: SystemOptions = together(SystemOptions),
    words: tuple[str, ...] = arguments("component|system NAME"),
) -> None:
    r"""Begin the profile of a component or of a system.

    An RTC profile or an RTS profile.

    It is valid at once. A file that is there is not replaced without --force; an output that ends
    in .yaml or .json is written in that form, and - is stdout. Standard data types need no module.

    A component implements onInitialize, onActivated, onDeactivated and onExecute unless --callback
    tells others. Components of a system have the ports, parameters and rates of their profiles.
    """
    from rtkit.link.atomic import write_output
    from rtkit.profile.forms import XML, form_of_name
    from rtkit.profile.write import write_profile

    kind, name = _read(words)
    parts, others = (component, system) if kind == "rtc" else (system, component)
    _refuse(others._asdict(), kind)
    place = output or f"{name}.xml"
    if not force and place != "-" and os.path.lexists(place):
        raise Refused(f"{place} is there already; --force replaces it")
    given = {key: value for key, value in parts._asdict().items() if value not in (None, ())}
    make = _component if kind == "rtc" else _system
    profile = make(name, vendor, release, description, given)
    write_output(write_profile(profile, form_of_name(place) or XML), place, is_new=not force)


def _read(words: Sequence[str]) -> tuple[str, str]:
    if len(words) != 2:
        raise WrongArguments("takes what to begin and its name: component NAME or system NAME")
    kind = _KINDS.get(words[0])
    if kind is None:
        raise UsageProblem(f"no such kind of profile: {words[0]} (component or system)")
    return kind, words[1]


def _refuse(others: dict[str, Any], kind: str) -> None:
    """Refuse options that are for the other kind."""
    context = click.get_current_context()
    options = {option.name: option.opts[0] for option in context.command.params}
    for name, given in others.items():
        if given not in (None, ()):
            what = "a component" if kind == "rtc" else "a system"
            raise UsageProblem(f"{options[name]} is not for {what}")


def _now() -> str:
    from datetime import datetime

    return datetime.now().astimezone().replace(microsecond=0).isoformat()


def _component(
    name: str, vendor: str, release: str, description: str, given: dict[str, Any]
) -> RtcProfile:
    from rtkit.profile_tools import new_component as new

    ports = [new.data_port(text, "DataInPort") for text in given.pop("ins", ())]
    ports += [new.data_port(text, "DataOutPort") for text in given.pop("outs", ())]
    wishes = [new.interface(text, "Provided") for text in given.pop("provides", ())]
    wishes += [new.interface(text, "Required") for text in given.pop("requires", ())]
    parameters = [_fitting(new.parameter(text)) for text in given.pop("parameters", ())]
    callbacks = given.pop("callbacks", _CALLBACKS)
    heading = new.ComponentHeading(name, _now(), vendor, version=release, description=description)
    return new.new_component(
        heading._replace(**given), ports, new.service_ports(wishes), parameters, callbacks
    )


def _fitting(item: ConfigurationParameter) -> ConfigurationParameter:
    """Refuse a parameter whose default breaks its own type or constraint."""
    from rtkit.component.configuration.constraint_check import Declared, misfit_of
    from rtkit.profile.constraint_text import format_constraint

    rule = format_constraint(item.constraint)
    why = misfit_of(Declared(item.type, rule, item.constraint), item.default_value)
    if why:
        raise Malformed(f"{item.name} cannot be {item.default_value!r}: {why}")
    return item


def _system(
    name: str, vendor: str, release: str, description: str, given: dict[str, Any]
) -> RtsProfile:
    from rtkit.profile_tools.new_system import in_slaves, new_system

    members: list[NewMember] = []
    for text in given.get("members", ()):
        members.append(_member(text, [member.instance for member in members]))
    return new_system(
        name,
        _now(),
        in_slaves(members, given.get("slaves", ())),
        given.get("connections", ()),
        vendor=vendor,
        version=release,
        abstract=description,
        host=given.get("host", "localhost"),
    )


def _member(text: str, taken: Sequence[str]) -> NewMember:
    from rtkit.profile.read import read_file
    from rtkit.profile.rtc_model import RtcProfile
    from rtkit.profile_tools.component_scene import component_name
    from rtkit.profile_tools.new_system import NewMember, default_instance

    file, colon, instance = text.rpartition(":")
    if not colon or os.path.exists(text):
        file, instance = text, ""
    profile = read_file(file, kind="rtc").profile
    assert isinstance(profile, RtcProfile)
    return NewMember(profile, instance or default_instance(component_name(profile), taken))
