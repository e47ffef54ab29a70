"""Statecharts for other programs: SCXML of charts and missions, and charts out of SCXML."""
