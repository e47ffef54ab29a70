"""What commands print: lines, tables, live views, JSON Lines, progress, files."""
