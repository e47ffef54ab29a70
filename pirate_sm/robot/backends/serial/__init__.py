"""The serial backend: a real robot on its port, over rosserial and without ROS.

``link`` is the pure driver (bytes and the time in, events and bytes out). ``recovery`` decides
how a silence ends. ``guardian`` is the process that owns the port and stops the robot when this
program cannot. ``ports`` describes a serial port. ``backend`` joins them behind the backend
protocol, and ``assembly`` makes it from a robot's files.
"""
