"""The options of commands; importing them is quick. Of a run: ``core/options.py``."""
