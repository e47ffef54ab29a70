"""What other people's viewers need: messages, a scene, a robot description, layouts."""
