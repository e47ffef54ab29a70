"""The guardian: a process that owns the port and stops the robot when the runner cannot.

``guard`` decides what to do, and has the messages between guardian and runner; ``process`` is the
process around it. ``guarded_port`` starts that process, and is the port as the runner sees it. With
``takeover`` a new run gets the port from a guardian that has outlived its runner.
"""
