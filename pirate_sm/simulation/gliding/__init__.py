"""Cycles of a simulated robot in one compiled call, as long as no frame concerns the engine."""
