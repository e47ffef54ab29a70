"""A recorded run as one page that needs nothing else: words, pictures, plots.

``docs/reports.md`` says how to read it. :mod:`pirate_sm.report.gathering` makes a plain model of a
run, :mod:`pirate_sm.report.page` makes HTML of that.
"""
