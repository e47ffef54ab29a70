"""JSON Schemas of missions, pipes, profiles and charts, with which editors complete and explain.

Draft 7, the newest that yaml-language-server, behind most editors' YAML, understands.
"""
