"""The library that draws in space, as a script that a page can contain: three.js, vendored."""

from __future__ import annotations

from importlib.resources import files

FOLDER = "three-0.170.0"
_NAME = "THREE"


def three_script() -> str:
    """Return the library as a classic script that defines ``THREE``, with its licence.

    The vendored file is a module. One inside a page cannot be imported without an address, so that
    its list of exports becomes the members of an object.
    """
    folder = files("pirate_sm.report") / "page" / FOLDER
    licence = (folder / "LICENSE").read_text("utf-8").strip()
    module = (folder / "three.module.min.js").read_text("utf-8")
    body, _, exports = module.rpartition("export{")
    names = (
        each.split(" as ") for each in exports.strip().removesuffix(";").rstrip("}").split(",")
    )
    members = ",".join(f"{each[-1]}:{each[0]}" for each in names)
    return (
        f"/*\n{licence}\n*/\nconst {_NAME}=(()=>{{'use strict';{body}\nreturn {{{members}}};}})();"
    )
