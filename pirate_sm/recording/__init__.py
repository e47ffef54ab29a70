"""A run kept whole: written while it runs, read again by replay, comparison, export and report.

``docs/recordings.md`` describes the files for other programs. :mod:`pirate_sm.recording.reader` is
the door for those that read, :mod:`pirate_sm.recording.recorder` for those that write.
"""
