"""Graphs as text in other languages: Mermaid and DOT."""
