"""Recordings of runs: written while a mission runs, read again by replay, export and report.

``docs/recordings.md`` describes the files for other programs.
:mod:`pirate_sm.running.recording.read.reader` opens a recording,
:mod:`pirate_sm.running.recording.write.recorder` writes one.
"""
