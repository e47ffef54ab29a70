"""JSON Schemas of missions, pipes, profiles and charts, for completion and help in editors.

They use draft 7, the newest that yaml-language-server supports, which most editors use.
"""
