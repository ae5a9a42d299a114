"""Renames modules as fissix does, but for those that are siblings of a component."""

from __future__ import annotations

from typing import Any, ClassVar

from fissix.fixes.fix_imports import MAPPING, FixImports

from rtkit.openrtm.migrate.package_imports import is_beside

_OTHERWISE = {"dummy_thread": "_thread", "dummy_threading": "threading"}
"""Modules whose new name Python 3.9 has no more, either."""


class FixModules(FixImports):  # type: ignore[misc]  # fissix tells no types
    """Fixer of imports, and of the names behind them."""

    mapping: ClassVar = {**MAPPING, **_OTHERWISE}

    def transform(self, node: Any, results: Any) -> None:
        """See `fissix.fixer_base.BaseFix`."""
        name = results.get("module_name")
        if name is None or not is_beside(self.filename, name.value):
            super().transform(node, results)
