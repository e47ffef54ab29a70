"""The options of commands; importing them is quick. Of a run: ``core/_model/run_options.py``."""
