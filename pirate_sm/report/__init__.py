"""A recorded run as one HTML page that needs no other file: words, pictures, plots.

``docs/reports.md`` says how to read it. :mod:`pirate_sm.report.report_builder` makes plain values
of a run, :mod:`pirate_sm.report.report_page` makes HTML of them.
"""
