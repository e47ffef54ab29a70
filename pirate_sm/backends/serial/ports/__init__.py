"""What the driver asks of a serial port, and the real one (pyserial)."""
