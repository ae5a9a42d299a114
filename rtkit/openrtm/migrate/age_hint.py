"""Tells how a source of an older Python, which fails while it runs, is converted."""

from __future__ import annotations

from rtkit.openrtm.migrate.python2 import is_python2_error


def age_hint(error: BaseException, file: str) -> str:
    """Return how a running source of an older Python is converted, with a colon before; else ""."""
    what = is_python2_error(error)
    if what:
        return f": {what} is Python 2, which rtkit openrtm migrate {file} converts"
    module = getattr(getattr(error, "obj", None), "__name__", "")
    if isinstance(error, AttributeError) and module:
        from rtkit.openrtm.migrate.lost_names import is_lost  # most errors are others

        if is_lost(module, error.name or ""):
            return f": older versions of Python had it; rtkit openrtm migrate {file} mends it"
    return ""
