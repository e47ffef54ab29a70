"""Repeats the experiments of a robot's thesis, and judges our values by the thesis's."""
