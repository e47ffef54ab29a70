"""What all views of a run share: snapshots, lines of text, panels, a canvas of characters."""
