"""Names of SCXML 1.0, and of what we add to it."""

from __future__ import annotations

from typing import Final

SCXML: Final = "http://www.w3.org/2005/07/scxml"
"""The namespace of SCXML 1.0 (W3C Recommendation, 1 September 2015)."""

OURS: Final = "urn:pirate-sm"
"""The namespace of what SCXML has no word for; other programs ignore it."""
