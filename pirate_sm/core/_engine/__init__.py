"""The pure core: ``(state, event, now) -> (state, effects)``, for any robot and any mission.

It reads no clock, no file and no port. Other packages enter through
:mod:`pirate_sm.core._engine.engine`.
"""
