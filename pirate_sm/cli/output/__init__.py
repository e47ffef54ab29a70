"""The output of commands: lines, tables, live views, JSON Lines, progress, files."""
