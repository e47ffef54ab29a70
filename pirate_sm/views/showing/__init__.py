"""What every view of a run shares: snapshots, panels, the robot in its pipe, words for people."""
