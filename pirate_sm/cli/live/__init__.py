"""The view of a running mission on a terminal; loaded only when there is one."""
