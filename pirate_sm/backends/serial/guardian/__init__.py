"""The guardian: a process that owns the port and stops the robot when the runner cannot.

``guard`` decides, ``process`` is the process around it, ``notes`` what runner and guardian say to
each other, ``guarded_port`` and ``virtual_port`` the port as the runner sees it, ``takeover`` how
a new run gets the port from a guardian that has outlived its runner.
"""
