"""The serial backend: a real robot on its port, over rosserial and without ROS.

``link`` is the pure driver (bytes and the time in, events and bytes out). ``guardian`` is the
process that owns the port and stops the robot when this program cannot. ``port`` describes a
serial port, ``serial_port`` is the real one. ``backend`` joins them behind the backend protocol,
and ``assembly`` makes it from a robot's files.
"""
