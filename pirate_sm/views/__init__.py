"""What people see of a run, a robot or a mission: pages, drawings, the console, other formats."""
