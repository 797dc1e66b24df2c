"""Write JSON files that any reader can read: no NaN, no arrays."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from jaxatt.runtime.files import replacing


def write_json(content: Mapping[str, Any], path: str | Path) -> None:
    """Write a mapping as a JSON file, completely or not at all."""
    with replacing(path) as partial:
        partial.write_text(json.dumps(plain(content), indent=2) + "\n", encoding="utf-8")


def plain(value: Any) -> Any:
    """Convert to plain Python for JSON; numbers that are not finite become None."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    return None if isinstance(value, float) and not math.isfinite(value) else value
