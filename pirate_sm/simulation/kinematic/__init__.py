"""The kinematic physics: position-based dynamics of a chain of wheels and links."""
