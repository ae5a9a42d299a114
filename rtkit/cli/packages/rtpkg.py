"""``rtpkg``: packages of components, a module for each word."""

from __future__ import annotations

from rtkit.cli.shared.group import group

_HELP = """Build, publish, find and install packages of components.

A package is a wheel with modules of components, their RTC profiles and IDL. Repositories are
folders of wheels, simple indexes (http:, https:), and folders in git repositories
(git+URL@REVISION#subdirectory=FOLDER): --repository names them, or repositories = [...] in
rtkit.toml. Versions are installed side by side; managers find the one that an id names. A bundle
is a system with all its packages, in one file.
"""

main = group(
    "rtpkg",
    _HELP,
    ["build", "publish", "list", "search", "install", "uninstall", "bundle", "sign"],
    examples=(
        ("rtpkg build Scale -o wheels", "Make a package of a component's folder."),
        ("rtpkg install 'rtc-scale>=1.2,<2' --repository wheels", "Install it for managers here."),
    ),
)
