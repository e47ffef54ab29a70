"""The kinematic physics in space: the same chain in round pipes, with its roll joint."""
