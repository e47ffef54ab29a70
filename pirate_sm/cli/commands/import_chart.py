"""`pirate import`: makes a robot's chart from SCXML."""

from __future__ import annotations

from pirate_sm.cli.options.files import ImportOptions
from pirate_sm.cli.output.files import refuse_losses, write_or_print
from pirate_sm.cli.output.terminal import progress
from pirate_sm.core.documents import Problems, read_text
from pirate_sm.core.library import shown
from pirate_sm.core.loading import cached_table
from pirate_sm.core.visible import visible
from pirate_sm.views.interchange.scxml_chart_reader import chart_text, read_chart


def import_chart(options: ImportOptions) -> int:
    """Write the chart to the file, or to standard output; return the exit code.

    Raises:
        LoadError: The SCXML cannot be read, or is not a chart of the supported kind.
        UsageError: The chart cannot be written.
    """
    refuse_losses([options.output], inputs=[options.file], overwrite=options.overwrite)
    name = shown(options.file)
    text = read_text(options.file, name, "SCXML")
    document, outline = read_chart(text, name, options.file.stem)
    with progress(f"exploring {visible(name)}") as watch:
        table = cached_table(document, outline, Problems(document), watch)
    write_or_print(options.output, chart_text(document.data, options.file.name))
    if options.output is not None:
        print(
            f"{options.output} is a chart with {len(table.regions)} regions, "
            f"{len(table.commands)} commands and {len(table.configurations)} configurations"
        )
    return 0
