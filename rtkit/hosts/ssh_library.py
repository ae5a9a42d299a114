"""Imports paramiko without invoke, which brings asyncio and unittest and half of its start-up time.

It is for commands of ``Match exec`` only, of which none is ever run.
"""

from __future__ import annotations

import sys
from types import ModuleType
from typing import cast

_IDLE = "invoke"
_is_absent = _IDLE not in sys.modules
if _is_absent:
    sys.modules[_IDLE] = cast(ModuleType, None)  # an import of it fails, which paramiko bears
try:
    import paramiko as paramiko
finally:
    if _is_absent:
        del sys.modules[_IDLE]
