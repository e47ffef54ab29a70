"""Missions, charts and pipes as one neutral graph, in Mermaid, DOT or SVG; robots as pages."""
