"""The real robot on its serial port: rosserial without ROS.

Pure layers below, each with time as an argument and none with I/O: ``framing`` (bytes and
frames), ``messages`` (frames and values), ``conversation`` (topics, time, silence), ``link``
(setpoints until they are echoed), ``measurements`` and ``supervision`` (sensors), and
``exchange``, which joins them. On top ``backend``, over a ``port``; ``guardian`` owns the real one.
"""
