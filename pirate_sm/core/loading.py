"""Read files into models; report all faults of a file together."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._loading import references, trace_script
from pirate_sm.core._loading.chart.guards import States, asked_by, conjuncts, holds
from pirate_sm.core._loading.chart.outline import ChartOutline, ChartTransition, StateNode
from pirate_sm.core._loading.chart.outline_reader import outline_chart
from pirate_sm.core._loading.chart.table_cache import cached_table
from pirate_sm.core._loading.mission.holding import holding_in
from pirate_sm.core._loading.mission.loader import TOLERABLE, LoadedMission, load_mission
from pirate_sm.core._loading.mission.manual_mission import BY_HAND, by_hand
from pirate_sm.core._loading.mission.parameter_values import Value, Values, defaults, read_value
from pirate_sm.core._loading.mission.route_mission import (
    UndrivableError,
    course_along,
    mission_along,
)
from pirate_sm.core._loading.mission.scope import TIME_LIMIT, trigger_names
from pirate_sm.core._loading.mission.start_configuration import read_states
from pirate_sm.core._loading.pickling import MissionPickler
from pirate_sm.core._loading.pipe_file import (
    FOLDING_ROOM_RAD,
    check_fit,
    check_reach,
    load_pipe,
    reach,
)
from pirate_sm.core._loading.pipe_shape import check_pipe
from pirate_sm.core._loading.references import followed, project_of
from pirate_sm.core._loading.robot.calibration_files import (
    LARGEST_ZERO_RAD,
    joints_of,
    keep_calibration,
    load_calibration,
    newest_calibration,
    summary,
    with_zeros,
)
from pirate_sm.core._loading.robot.loader import LoadedRobot, load_robot, read_robot, with_fitted
from pirate_sm.core._loading.robot.twin_file import check_twin, load_twin, simulated_profile
from pirate_sm.core._loading.trace_script import read_script
from pirate_sm.core._loading.yaml.error_wording import word
from pirate_sm.core._loading.yaml.validation import try_validate, validate
