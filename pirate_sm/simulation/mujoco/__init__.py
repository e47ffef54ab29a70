"""The physics of a chain of rigid bodies by MuJoCo: in a plane, or in space in a round pipe."""
