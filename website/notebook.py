"""Shows a notebook, with its stored outputs, as a page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any


def page(notebook: Mapping[str, Any]) -> str:
    """Return the Markdown of a notebook: its texts, its code, and what the code has shown."""
    return "\n\n".join(part for cell in notebook["cells"] for part in _parts(cell)) + "\n"


def _parts(cell: Mapping[str, Any]) -> Iterator[str]:
    source = "".join(cell["source"])
    if cell["cell_type"] == "markdown":
        yield source
        return
    yield f"```python\n{source}\n```"
    for output in cell["outputs"]:
        if "text" in output:
            yield f"```text\n{''.join(output['text']).rstrip()}\n```"
            continue
        data = output["data"]
        if "text/html" in data:
            yield f'<div class="output">\n{"".join(data["text/html"])}\n</div>'
        else:
            yield f"```text\n{''.join(data['text/plain']).rstrip()}\n```"
