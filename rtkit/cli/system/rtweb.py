"""``rtweb``: the system editor in the browser."""

from __future__ import annotations

import secrets

import click

from rtkit.cli.shared import terminal
from rtkit.cli.shared.app import App
from rtkit.cli.shared.command import command
from rtkit.cli.shared.options import flag, option
from rtkit.errors import NotFound, Refused


@command(
    "rtweb",
    examples=(
        ("rtweb", "Open the system editor in the browser."),
        ("rtweb --no-browser --port 8080", "Print its address only; the port is always the same."),
        ("rtweb --read-only", "Look, and change nothing."),
        (
            "rtweb --bind 10.0.0.7 --cert robot.crt --key robot.key",
            "For browsers of other hosts, by TLS.",
        ),
        ("rtweb --root robots", "Save and compare system profiles in that folder, too."),
    ),
    arguments=(),
)
def main(
    app: App,
    port: int | None = option(
        "--port N", "Port on this host (default: a free one).", click.IntRange(1, 65535)
    ),
    address: str = option(
        "--bind ADDRESS", "Listen there, for other hosts (default: this host only).", default=""
    ),
    cert: str = option("--cert FILE", "Certificate of the page (PEM), for TLS.", default=""),
    key: str = option("--key FILE", "Its key.", default=""),
    is_insecure: bool = flag(
        "--insecure", "Let other hosts in without TLS, too; every rtls -l shows it."
    ),
    is_read_only: bool = flag("--read-only", "Change nothing."),
    roots: tuple[str, ...] = option(
        "--root FOLDER",
        "The page may read and write system profiles in this folder; repeatable.",
        multiple=True,
    ),
    no_browser: bool = flag("--no-browser", "Open no browser."),
) -> None:
    """Serve the system editor as a page for the browser, until Ctrl-C.

    The page shows what lives in all managers of this host and of linked hosts, as it changes, and
    connects, configures, activates, creates and ends components. Each action is a command line,
    which the page shows; what has an inverse can be undone. Each change is a line on stderr, too:
    when, by which page, what, the old value and the new one.

    In folders that are granted with --root it saves the system, as rtcryo does, and compares it
    with profiles, as rtcheck does. Links in them are not followed.

    Only browsers of this host reach it, unless --bind says otherwise: then by TLS, with --cert and
    --key, or with --insecure, when whoever is between reads the secret and takes the page over. The
    address that is printed has a secret, good until the command ends: who has it does what you may
    do.
    """
    try:
        from rtkit.web.server import STATIC, WebServer, serve
    except ImportError as error:
        if (error.name or "").partition(".")[0] not in ("starlette", "uvicorn", "anyio"):
            raise
        from rtkit.extras import how_to_get

        raise Refused(f"the page needs starlette and uvicorn: {how_to_get('web')}") from None
    from rtkit.web.audit.line_writer import written_aside
    from rtkit.web.guard import WebGuard
    from rtkit.web.opening import signpost
    from rtkit.web.reach import HERE, reach_of
    from rtkit.web.site import WebSite

    check_built(STATIC)
    folders = [_folder(each) for each in roots]
    app.needs_reader = False  # a script may read the address, and let the page be served on
    reach = reach_of(address or HERE, port or 0, cert, key, is_insecure=is_insecure)
    token = secrets.token_urlsafe(16)
    guard = WebGuard(token, reach.names, reach.scheme, reach.is_public)
    if reach.is_public and reach.tls is None:
        app.fail(f"warning: {reach.site} is not encrypted: who listens in can take the page over")
    forget = reach.noted()

    with signpost() as lead, written_aside(app.fail) as log:
        site = WebSite(app, folders, log, is_read_only=is_read_only)

        def ready() -> None:
            shown = f"{reach.site}#token={token}"
            terminal.write_now([shown])
            if not (no_browser or lead(shown)):
                app.fail("no browser was found here: open the address yourself")

        try:
            serve(WebServer(site, guard, ready), reach.listener, reach.tls)
        finally:
            forget()


def _folder(typed: str) -> str:
    """Return the path of a folder that is granted, without links.

    Raises:
        NotFound: There is no such folder.
    """
    import os

    if not os.path.isdir(typed):
        raise NotFound(f"No such folder: {typed}")
    return os.path.realpath(typed)


def check_built(folder: str) -> None:
    """Refuse to serve a page that was not built into this installation.

    Raises:
        Refused: Tells how to build it.
    """
    import os

    if not os.path.exists(os.path.join(folder, "index.html")):
        raise Refused("this installation has no page: install rtkit from a wheel, or make web")
