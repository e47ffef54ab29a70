"""What one version of a mission can do and another cannot."""
