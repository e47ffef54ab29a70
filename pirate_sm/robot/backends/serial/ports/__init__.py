"""Serial ports: the protocol that the driver uses, and the real port (pyserial)."""
