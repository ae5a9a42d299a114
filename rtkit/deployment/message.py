"""Messages between a manager and its processes: tables, as they travel."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

Message = Mapping[str, Any]
