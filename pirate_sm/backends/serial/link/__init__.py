"""The driver of the serial link without its port: bytes and the time in, events and bytes out.

``exchange`` joins the parts: ``conversation`` (topics, time, silence), ``arrays`` (setpoints until
they are echoed), ``measurements`` (readings to sensor frames) and ``throttle`` (what may be
written when), with the numbers of one robot from ``link_plan``.
"""
