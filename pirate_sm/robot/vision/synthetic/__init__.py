"""Draw what a camera would see: the setup and the robot through the lens, with light and errors."""
