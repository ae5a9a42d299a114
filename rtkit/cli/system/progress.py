"""Reports progress when a command whose plan is never undone breaks off."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from rtkit.cli.shared.app import App
from rtkit.errors import RtkitError

if TYPE_CHECKING:
    from rtkit.deployment.live import LiveIndex
    from rtkit.deployment.system import WantedSystem


@contextmanager
def telling(
    app: App, system: WantedSystem, tell: Callable[[WantedSystem, LiveIndex], str]
) -> Iterator[None]:
    """Add the progress to an error that ends the command; `tell` reads it off the live system.

    Raises:
        RtkitError: What was raised inside.
        KeyboardInterrupt: Likewise.
    """
    try:
        yield
    except RtkitError as error:
        raise type(error)(f"{error}; {_progress(app, system, tell)}") from error
    except KeyboardInterrupt as error:
        more = _progress(app, system, tell)
        raise KeyboardInterrupt("; ".join(filter(None, (str(error), more)))) from error


def _progress(
    app: App, system: WantedSystem, tell: Callable[[WantedSystem, LiveIndex], str]
) -> str:
    from rtkit.deployment.live import LiveIndex
    from rtkit.tree.grace import uninterrupted

    try:
        return tell(system, LiveIndex(uninterrupted(lambda: app.tree.remains()), system))
    except (RtkitError, KeyboardInterrupt) as trouble:
        return f"how far it got is not known ({str(trouble) or 'interrupted again'})"
