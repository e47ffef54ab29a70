"""Real robots: backends and links, detectors, cameras, control panels, diagnosis."""
