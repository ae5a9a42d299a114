"""``rtdoc``: a page about a component, from what it says of itself."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtkit.cli.shared.app import App, check_at_most_one, no_such
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, flag, option
from rtkit.errors import Malformed, UsageProblem
from rtkit.link.atomic import STDOUT

if TYPE_CHECKING:
    from rtkit.cli.profiles.doc_subject import DocumentedComponent
    from rtkit.profile_tools.page import Section
    from rtkit.rtc.profiles import TypeProfile

FORMS = ("html", "rst", "latex", "markdown", "text")
_OTHER_NAMES = {"md": "markdown", "tex": "latex", "htm": "html", "txt": "text", "plain": "text"}
_WITH_GRAPH = ("html", "rst", "markdown")
_OWN = ("Data ports", "Service ports", "Ports", "Configuration parameters", "Parameters")


@command(
    "rtdoc",
    examples=(
        ("rtdoc /localhost/Robot0.rtc > Robot0.html", "A page about a live component."),
        ("rtdoc -f markdown -o Robot.md Robot.py", "About a module that nobody has loaded."),
    ),
    arguments=("component",),
)
def main(
    app: App,
    form: str = option(
        "-f --format FORM", f"One of {', '.join(FORMS)} (default html).", default="html"
    ),
    graph: bool = flag(
        "-g --graph", "Draw its ports too: in html, rst, and markdown that is written to a file."
    ),
    output: str = option(
        "-o --output FILE", "Where to write it (default -, stdout).", default=STDOUT
    ),
    words: tuple[str, ...] = arguments("COMPONENT | MODULE.py[:FACTORY]"),
) -> None:
    """Write a page about a component.

    Its configuration set __doc__ has the texts: intro, reqs, install, usage, misc, changelog and
    others by their names, __license__, __contact__, __url__, and in __order__ the order of the
    sections. Ports (their property description) and parameters (the set __description__) are
    added. Of a component without such a set its RTC profile is taken, if one is found. A module
    is imported, and an instance made of it: its code runs.
    """
    chosen = _form(form)
    if graph and chosen not in _WITH_GRAPH:
        raise UsageProblem(f"-g: a page in {chosen} has no picture ({', '.join(_WITH_GRAPH)} have)")
    if not words:
        raise Malformed("No component specified.")
    check_at_most_one(words, "component")
    from rtkit.cli.profiles.doc_subject import dot_of, page_of
    from rtkit.cli.profiles.document import write_page

    subject = _of_module(words[0]) if _is_module(words[0]) else _of_tree(app, words[0])
    if not subject.has_documentation:
        subject = subject._replace(more=_from_profile(app, subject.type))
    made = page_of(subject, has_picture=graph)
    for warning in made.warnings:
        app.fail(f"warning: {warning}")
    if chosen == "markdown" and made.page.picture and output == STDOUT:
        raise UsageProblem("-g: the picture of a page in markdown is a file beside it: -o FILE")
    write_page(made.page, chosen, output, dot_of(subject) if graph else "")


def _form(typed: str) -> str:
    form = _OTHER_NAMES.get(typed.lower(), typed.lower())
    if form not in FORMS:
        raise UsageProblem(no_such("format", typed, FORMS))
    return form


def _is_module(typed: str) -> bool:
    return typed.endswith(".py") or ".py:" in typed


def _of_module(typed: str) -> DocumentedComponent:
    from rtkit.cli.profiles.doc_subject import DocumentedComponent
    from rtkit.cli.profiles.factory import component_class, instance_of
    from rtkit.component.describe import describe

    component = instance_of(component_class(typed, "").cls, typed, is_initialised=False)
    described = describe(component)
    return DocumentedComponent(component.type, described.ports, described.sets)


def _of_tree(app: App, typed: str) -> DocumentedComponent:
    from rtkit.cli.profiles.doc_subject import DocumentedComponent

    facts = app.facts(app.path(typed))
    if facts.trouble:
        app.fail(f"warning: as last reported ({facts.trouble}): {typed}")
    return DocumentedComponent(facts.type, facts.ports, facts.sets)


def _from_profile(app: App, type: TypeProfile) -> tuple[Section, ...]:
    """Return the documentation in the RTC profile of a type besides ports and parameters."""
    from rtkit.api.component_profiles import profiles
    from rtkit.errors import RtkitError
    from rtkit.profile.read import read_profile
    from rtkit.profile.rtc_model import RtcProfile
    from rtkit.profile_tools.component_page import component_page

    wanted = (type.vendor, type.category, type.type_name)
    for name, data in profiles((), app.verbose):
        if type.type_name.encode() not in data:
            continue
        try:
            profile = read_profile(data, name).profile
        except RtkitError as error:
            app.verbose(str(error))
            continue
        info = profile.basic_info if isinstance(profile, RtcProfile) else None
        if info is not None and (info.vendor, info.category, info.name) == wanted:
            assert isinstance(profile, RtcProfile)
            return tuple(s for s in component_page(profile).sections if s.title not in _OWN)
    return ()
