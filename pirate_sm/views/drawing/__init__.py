"""Missions and charts as pictures: one neutral graph, written as Mermaid, DOT or SVG."""
