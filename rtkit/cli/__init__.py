"""The commands: one file each, by topic; all of them are in the generated `rtkit.cli.table`."""

from __future__ import annotations

import _signal  # type: ignore[import-not-found]
import gc
import sys

_MANY = 50_000
"""New objects after which the collector of cycles looks at them; 700 are usual."""


def _begin_script() -> None:
    """Prepare this process for a console script; a plain import of a command changes nothing.

    Ctrl-C ends it without a traceback while it still imports. The module `signal` itself takes as
    long to import as all that comes before this. And what is imported lives until the end: to
    look through it for cycles again and again is a tenth of the time of a whole rtls
    (decision 35).
    """
    script = sys.argv[0].rpartition("/")[2] if sys.argv else ""
    # All our scripts are named so; the table itself is not worth an import here.
    if not (script.startswith("rt") and script.isalpha()):
        return
    gc.set_threshold(_MANY, *gc.get_threshold()[1:])
    if _signal.getsignal(_signal.SIGINT) is _signal.default_int_handler:
        _signal.signal(_signal.SIGINT, _signal.SIG_DFL)


_begin_script()


def main() -> int:
    """Run ``rtkit VERB …``."""
    from rtkit.cli.unified import run

    return run()
