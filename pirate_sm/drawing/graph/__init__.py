"""The neutral graph that is drawn, and how missions and charts become one."""
