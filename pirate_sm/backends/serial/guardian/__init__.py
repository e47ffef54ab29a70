"""The guardian: a process that owns the port and stops the robot when the runner cannot.

``guard`` decides (``guard_actions``), ``process`` is the process around it, which the runner
starts by ``guardian_process``. ``notes`` are what they say to each other, ``guarded_port`` the port
as the runner sees it. By ``takeover`` a new run gets the port from a guardian that has outlived its
runner.
"""
