"""The version of this program as a campaign counts it: results of different code are not mixed."""

from __future__ import annotations

from functools import cache
from hashlib import sha256
from pathlib import Path

import pirate_sm

_DIGITS = 12


@cache
def code_version() -> str:
    """Return the version of the package with a digest of its Python files.

    Equal versions in different working copies may compute differently; their digests differ.
    """
    root = Path(pirate_sm.__file__).parent
    digest = sha256()
    for file in sorted(root.rglob("*.py")):
        digest.update(file.relative_to(root).as_posix().encode() + b"\0")
        digest.update(file.read_bytes() + b"\0")
    return f"{pirate_sm.__version__}+{digest.hexdigest()[:_DIGITS]}"
