"""The robot as it is commanded: its chart, its commands, and what confirms them."""
