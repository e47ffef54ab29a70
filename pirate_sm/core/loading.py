"""Read files into models; report all faults of a file together."""

# ruff: noqa: F401
# mypy: implicit-reexport
from __future__ import annotations

from pirate_sm.core._loading import references
from pirate_sm.core._loading.chart_exploration import cached_table
from pirate_sm.core._loading.chart_outline import (
    ChartOutline,
    ChartTransition,
    StateNode,
    States,
    asked_by,
    conjuncts,
    holds,
    outline_chart,
)
from pirate_sm.core._loading.mission.called_missions import read_states
from pirate_sm.core._loading.mission.loader import (
    TOLERABLE,
    UNFINISHED,
    LoadedMission,
    holding_in,
    load_mission,
)
from pirate_sm.core._loading.mission.parameter_values import Value, Values, defaults, read_value
from pirate_sm.core._loading.mission.scope import TIME_LIMIT, trigger_names
from pirate_sm.core._loading.pipe import (
    FOLDING_ROOM_RAD,
    check_pipe,
    check_reach,
    load_pipe,
    reach,
)
from pirate_sm.core._loading.references import project_of
from pirate_sm.core._loading.robot.loader import (
    LoadedRobot,
    load_robot,
    read_robot,
    with_fitted,
)
from pirate_sm.core._loading.robot.twin import check_twin, simulated_profile, twin_named
from pirate_sm.core._loading.yaml.error_wording import word
from pirate_sm.core._loading.yaml.validation import try_validate, validate
