"""Load a robot from its folder: read, check and resolve its profile and chart."""
