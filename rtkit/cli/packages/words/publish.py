"""``rtpkg publish``: put a package into a repository."""

from __future__ import annotations

from rtkit.cli.shared.app import App, WrongArguments
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import arguments
from rtkit.errors import InvalidDocument


@command(
    "publish",
    is_local=True,
    examples=(
        ("rtpkg publish rtc_scale-1.0.0-py3-none-any.whl wheels", "Into a folder."),
        (
            "rtpkg publish rtc_scale-1.0.0-py3-none-any.whl git+file:///srv/robot.git",
            "As a commit that is pushed.",
        ),
    ),
    arguments=("file", "file"),
)
def main(app: App, words: tuple[str, ...] = arguments("WHEEL REPOSITORY")) -> None:
    """Publish a package in a folder, or in a git repository, to which it is pushed.

    The wheel is checked as rtpkg build does. One of that name with other bytes is never replaced:
    what has changed needs a new version. A simple index takes none; publish to the folder that it
    serves.
    """
    from rtkit.packages.repository import publish
    from rtkit.packages.wheel import objections, read_wheel

    if len(words) != 2:
        raise WrongArguments("takes a wheel and a repository")
    found = objections(read_wheel(words[0]))
    if found:
        raise InvalidDocument(f"{words[0]} is no package: {'; '.join(found)}")
    publish(*words)
    app.verbose(f"{words[0]} is in {words[1]}")
