"""The libraries that a page contains, vendored with their licences: uPlot and three.js."""

from __future__ import annotations

from importlib.resources import files
from importlib.resources.abc import Traversable

PAGE = files("pirate_sm.report") / "page"
PLOTS = PAGE / "uplot-1.6.32"
SPACE = PAGE / "three-0.170.0"
_SPACE_NAME = "THREE"


def plot_script() -> str:
    """Return the library that plots as a script that defines ``uPlot``, with its licence."""
    return _licensed(PLOTS, (PLOTS / "uPlot.iife.min.js").read_text("utf-8"))


def plot_style() -> str:
    """Return the style sheet of the library that plots."""
    return (PLOTS / "uPlot.min.css").read_text("utf-8")


def three_script() -> str:
    """Return the library that draws in space as a script that defines ``THREE``, with its licence.

    The vendored file is a module. One inside a page cannot be imported without an address, so that
    its list of exports becomes the members of an object.
    """
    module = (SPACE / "three.module.min.js").read_text("utf-8")
    body, _, exports = module.rpartition("export{")
    names = (
        each.split(" as ") for each in exports.strip().removesuffix(";").rstrip("}").split(",")
    )
    members = ",".join(f"{each[-1]}:{each[0]}" for each in names)
    return _licensed(
        SPACE, f"const {_SPACE_NAME}=(()=>{{'use strict';{body}\nreturn {{{members}}};}})();"
    )


def _licensed(folder: Traversable, script: str) -> str:
    """Return a script below the licence in its folder, without addresses to look up."""
    licence = (folder / "LICENSE").read_text("utf-8").strip()
    return f"/*\n{licence}\n*/\n{script}"
