"""Output for viewers of other projects: messages, a scene, a robot description, layouts."""
