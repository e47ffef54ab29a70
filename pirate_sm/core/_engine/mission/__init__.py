"""The running mission: its program, its interpreter, its flow, its end, and plans of commands."""
