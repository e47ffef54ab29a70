"""Graphs, laid out, and plots as SVG without scripts, fonts or other external resources."""
