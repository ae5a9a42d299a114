"""The commands: one file each, by topic; all of them are in the generated `rtkit.cli.table`."""

from __future__ import annotations

import _signal  # type: ignore[import-not-found]
import gc
import sys
from types import ModuleType
from typing import Any

_MANY = 50_000
"""New objects after which the collector of cycles looks at them; 700 are usual."""


class _Postponed(ModuleType):
    """Stands for a module until something of it is used.

    Args:
        name: Of the module.
        function: One that others take at their import, and call later or never.
    """

    def __init__(self, name: str, function: str) -> None:
        super().__init__(name)
        self.__dict__[function] = lambda *args, **more: self.__getattr__(function)(*args, **more)

    def __getattr__(self, name: str) -> Any:
        """Import the module; return what is wanted of it."""
        if sys.modules.get(self.__name__) is self:
            del sys.modules[self.__name__]
        module = __import__(self.__name__)
        self.__dict__.update(vars(module))
        return getattr(module, name)


def _begin_script() -> None:
    """Prepare this process for a console script; a plain import of a command changes nothing.

    Ctrl-C ends it without a traceback while it still imports. The module `signal` itself takes as
    long to import as all that comes before this. And what is imported lives until the end: to
    look through it for cycles again and again is a tenth of the time of a whole rtls
    (decision 35). `inspect`, with the parser and tokenizer of Python, waits until it is used:
    click imports it to tidy texts of help, which our options bring tidy, and lxml for parsers
    that call back.
    """
    script = sys.argv[0].rpartition("/")[2] if sys.argv else ""
    # All our scripts are named so; the table itself is not worth an import here.
    if not (script.startswith("rt") and script.isalpha()):
        return
    if "inspect" not in sys.modules:
        sys.modules["inspect"] = _Postponed("inspect", "getfullargspec")
    gc.set_threshold(_MANY, *gc.get_threshold()[1:])
    if _signal.getsignal(_signal.SIGINT) is _signal.default_int_handler:
        _signal.signal(_signal.SIGINT, _signal.SIG_DFL)


_begin_script()


def main() -> int:
    """Run ``rtkit VERB …``."""
    from rtkit.cli.unified import run

    return run()
