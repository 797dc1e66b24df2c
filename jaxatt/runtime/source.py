"""The package's own source, as far as what is kept on disk depends on it."""

from __future__ import annotations

import functools
import hashlib
from pathlib import Path


@functools.cache
def source_digest() -> str:
    """Digest of the package's source."""
    code = hashlib.sha256()
    for source in sorted(Path(__file__).parents[1].rglob("*.py")):
        code.update(source.read_bytes())
    return code.hexdigest()
