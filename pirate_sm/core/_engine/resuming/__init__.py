"""Resume a mission after a crash: what may be so, what sensors show, where it continues.

Everything here is pure. :func:`.hypotheses.hypotheses` lists where the robot may be,
:func:`.reconciling.reconcile` compares that with what the boards show, and
:func:`.resumption.resumption` says where the mission continues, and what ``Engine.start`` starts it
with.
"""
