"""The core: files read into models, and the pure engine that runs them.

The rest of the package imports the modules of this folder only; what begins with an underscore is
private to the core, and import-linter keeps it so.
"""
