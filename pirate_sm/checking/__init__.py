"""What can be known of robots, missions and pipes before anything moves."""
