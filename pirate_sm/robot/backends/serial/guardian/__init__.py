"""The guardian: a process that owns the port and stops the robot when the runner cannot.

``guard`` decides what to do (``guard_actions``); ``process`` is the process around it, which the
runner starts by ``guardian_process``. ``notes`` are the messages between the two. ``guarded_port``
is the port as the runner sees it. With ``takeover`` a new run gets the port from a guardian that
has outlived its runner.
"""
