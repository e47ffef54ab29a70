"""The driver of the serial link without its port: bytes and the time in, events and bytes out.

``exchange`` joins the parts: ``conversation`` (topics, time, silence), ``arrays`` (setpoints until
they are echoed), ``measurements`` (readings to sensor frames) and ``throttle`` (when bytes may be
written). ``link_plan`` holds the numbers of one robot.
"""
