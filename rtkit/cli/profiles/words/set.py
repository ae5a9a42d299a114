"""``rtprofile set``: extension properties of a system and of its components, no parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import argument, arguments, option, several, strict_option
from rtkit.errors import Malformed

if TYPE_CHECKING:
    from rtkit.profile.rts_model import RtsProfile


@command(
    "set",
    is_local=True,
    examples=(
        ("rtprofile set robot.xml Control0:rtkit.restart=on-failure", "Restart it when it fails."),
        ("rtprofile set robot.xml Control0:rtkit.restart=", "Remove that again."),
    ),
)
def main(
    app: App,
    removed: tuple[str, ...] = several(
        "-u --unset [INSTANCE:]KEY", "Remove a property; repeatable."
    ),
    output: str | None = option("-o --output OUTPUT", "Where to write it (default FILE itself)."),
    strict: None = strict_option(),
    file: str | None = argument("FILE", required=False),
    given: tuple[str, ...] = arguments("[INSTANCE:]KEY=VALUE..."),
) -> None:
    """Set properties of a system and its components, in its profile.

    So policies of restart, rules of health (rtkit help survival) and limits (rtkit help limits) are
    written down, states of the system (rtkit help states), costs (rtkit.cost) and what else rtkit
    or others know. A setting that makes no sense is refused, and nothing is written; a name that
    looks like a property of rtkit and is none is warned of. The file is replaced whole; what FILE -
    reads goes to stdout.
    """
    from rtkit.cli.profiles.document import read_document, report_findings
    from rtkit.deployment.known_keys import odd_properties
    from rtkit.link.atomic import write_output
    from rtkit.profile.forms import form_of
    from rtkit.profile.rts_model import RtsProfile
    from rtkit.profile.write import write_profile
    from rtkit.profile_tools.rewriting import rewritten
    from rtkit.profile_tools.stating import stated, statement

    if file is None:
        raise WrongArguments("No file specified.")
    if not given and not removed:
        raise WrongArguments("No property specified.")
    statements = [statement(each) for each in given]
    statements += [statement(each, is_removal=True) for each in removed]
    document = read_document(app, file, kind="rts")
    assert isinstance(document.profile, RtsProfile)
    profile = stated(document.profile, statements)
    _check(profile)
    app.warn(each.text for each in odd_properties(profile))
    report_findings(app, rewritten(document.data, document.name).findings)
    write_output(write_profile(profile, form_of(document.data, document.name)), output or file)


def _check(profile: RtsProfile) -> None:
    """Refuse properties that make no sense.

    Raises:
        Malformed: Names the component and the property.
    """
    from rtkit.deployment.described import properties_of
    from rtkit.deployment.extension import SLAVE_RESTART
    from rtkit.deployment.health import read_rules
    from rtkit.deployment.limits import read_limits
    from rtkit.deployment.placement.profiles import requirements_of
    from rtkit.deployment.supervision import read_policy, restart_of

    for key, value in properties_of(profile.properties).items():
        if key.startswith(SLAVE_RESTART):
            restart_of(key, value)
    for component in profile.components:
        properties = properties_of(component.properties)
        try:
            read_policy(properties)
            read_rules(properties)
            read_limits(properties)
        except Malformed as error:
            raise Malformed(f"{component.instance_name}: {error}") from error
    requirements_of(profile)
