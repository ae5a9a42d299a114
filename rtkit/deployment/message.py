"""Messages between a manager and its processes: tables, as they travel."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

Message = Mapping[str, Any]
MISSING, NEW = "missing", "new"
"""What is done where a configuration set is not there: it is added; and one that is, is refused."""
