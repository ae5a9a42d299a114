"""``rtpkg bundle``: put a system and all its packages into one file."""

from __future__ import annotations

from rtkit.cli.packages.records import record, show
from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments, json_flag, option, several
from rtkit.cli.shared.system_values import PARAMETERS


@command(
    "bundle",
    is_local=True,
    examples=(
        ("rtpkg bundle robot.xml", "Writes robot.rtbundle; rtapply robot.rtbundle runs it."),
        ("rtpkg bundle robot.xml -o r.rtbundle --repository wheels", "Also what is not installed."),
    ),
    json=("package",),
    arguments=("file",),
)
def main(
    app: App,
    output: str = option(
        "-o --output FILE", "Where it goes (default: beside the profile).", default=""
    ),
    repositories: tuple[str, ...] = several(
        "--repository PLACE", "Where packages are that are not installed; repeatable."
    ),
    is_json: bool = json_flag(),
    parameters: None = PARAMETERS,
    words: tuple[str, ...] = arguments("SYSTEM"),
) -> None:
    """Bundle a system: its profile, the packages of its components, their SHA-256.

    The file is all that another machine with rtkit needs: rtapply FILE.rtbundle installs what is
    missing there and brings the system up, rtpkg install FILE.rtbundle only installs. No repository
    is asked. A changed byte is refused, and named. The same content is the same bytes. Wheels that
    rtkit itself has are not in it; a component that is of no package is refused.
    """
    import os
    import tempfile

    from rtkit.api.states import with_chart
    from rtkit.cli.system.document import read_as_is
    from rtkit.packages.bundle import SUFFIX, write
    from rtkit.packages.bundling import gather
    from rtkit.packages.precheck import known_repositories
    from rtkit.packages.repository import opened
    from rtkit.packages.wheel import read_wheel

    if len(words) != 1:
        raise WrongArguments("takes a system profile")
    document = with_chart(read_as_is(app, words))
    path = output or f"{os.path.splitext(words[0])[0]}{SUFFIX}"
    if not path.endswith(SUFFIX):
        raise WrongArguments(f"the name of a bundle ends in {SUFFIX}: {path}")
    with opened(known_repositories(repositories)) as there, tempfile.TemporaryDirectory() as draft:
        packages = gather(document.profile, there, draft)
        write(path, document.text().encode(), packages)
        records = []
        for name, files in sorted(packages.items()):
            wheels = [read_wheel(each) for each in files]
            types, needs = [each.id for each in wheels[0].types], wheels[0].requires
            digests = {each.file: each.sha256 for each in wheels}
            parts = name.split("==")
            records.append(
                record(parts[0], parts[1], path, types=types, requires=needs, wheels={**digests})
            )
    if is_json or app.is_verbose:
        show(records, is_json)
