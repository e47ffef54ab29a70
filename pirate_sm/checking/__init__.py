"""Find what is wrong with robots, missions and pipes before anything moves.

The rules are in `robot`, `mission` and `pipe`; `RULES` in `robot.check_robot`,
`mission.check_mission` and `pipe.check_in_pipe` list all of them. The codes and severities of
findings are in `catalogue`.
"""
