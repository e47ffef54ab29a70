"""What the files of a robot hold: its profile, its calibration, the numbers of its twin."""
