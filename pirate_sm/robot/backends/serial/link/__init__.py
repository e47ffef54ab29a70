"""The driver of the serial link without its port: bytes and the time in, events and bytes out.

``exchange`` joins the parts: ``conversation`` (topics, time, silence), ``arrays`` (setpoints until
they are echoed) and ``recovery`` (how a silence ends). ``link_plan`` holds the numbers of one robot
and limits the rate of writing, ``health`` shows the state of the link in numbers.
"""
