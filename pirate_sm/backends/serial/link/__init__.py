"""The driver without its port: pure, with the time as an argument.

``exchange`` joins the parts: ``conversation`` (topics, time, silence), ``arrays`` (setpoints until
they are echoed), ``measurements`` (readings to sensor frames) and ``throttle`` (what may be
written when), with the numbers of one robot from ``link_plan``.
"""
