"""The options of commands, quickly imported; those of a run are in ``core/_model/run_options.py``."""
