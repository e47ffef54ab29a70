"""A recorded run as one HTML page that needs no other file: words, pictures, plots.

``docs/reports.md`` explains how to read it. :mod:`pirate_sm.views.report.recording_report` collects
the contents of a run, :mod:`pirate_sm.views.report.report_page` writes them as HTML.
"""

GENERATOR = b'<meta name="generator" content="pirate-sm '
"""The line that identifies a page of any version of this program."""
