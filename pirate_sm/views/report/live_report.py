"""The report of a run while it is recorded: made again from what is there, whenever there is more.

It is the report of :mod:`pirate_sm.views.report.recording_report`, of a recording that has not
ended. So a page shows the same during a run, after it and in a replay.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pirate_sm.core.errors import PirateError
from pirate_sm.core.loading import LoadedMission
from pirate_sm.core.models import SIMULATORS
from pirate_sm.running.recording.forecast_file import ForecastFile, forecast_of, read_forecast
from pirate_sm.running.recording.read.growing import GrowingRecording
from pirate_sm.running.recording.recorded_mission import recorded_mission
from pirate_sm.running.recording.replay import rerun
from pirate_sm.views.report.contents import Photo, Report
from pirate_sm.views.report.expectations import with_expectations
from pirate_sm.views.report.film_strip import photos_of
from pirate_sm.views.report.poses import Poses
from pirate_sm.views.report.recording_report import RunContents, add_known
from pirate_sm.views.report.report_page import fragments, report_json
from pirate_sm.views.report.run_facts import about_run
from pirate_sm.views.report.timeline import DETECTOR

POLL_S = 0.05
"""How often the file is looked at, s."""

_SHARE = 0.5
"""The largest share of a processor that making reports may take: the run has the rest."""


@dataclass(frozen=True)
class Edition:
    """A report at one time of its run.

    Attributes:
        version: Its number, from 0.
        report: The report.
        data: The same as JSON, for the scripts of the page.
        parts: The same as HTML, by the names of the parts of the page.
    """

    version: int
    report: Report
    data: dict[str, Any]
    parts: dict[str, str]


def edition_of(report: Report, version: int = 0) -> Edition:
    """Return the edition of a page with this report."""
    return Edition(version, report, report_json(report), fragments(report))


class LiveReport:
    """Follows a recording in a thread of its own.

    Args:
        path: The recording.
        publish: Receives each edition, in that thread.
        failed: Receives, in that thread, why there is no edition and none will follow. What goes
            wrong after the first edition is a warning in the last one.
        forecast: File with earlier runs to compare it with; None: it is compared with none.

    Raises:
        RecordingError: There is no such file, it is not a recording, or its header is damaged.
    """

    def __init__(
        self,
        path: Path,
        publish: Callable[[Edition], None],
        failed: Callable[[Exception], None],
        forecast: Path | None = None,
    ) -> None:
        self._growing = GrowingRecording(path)
        self._earlier = forecast
        self._forecast: ForecastFile | None = None
        self._publish, self._failed = publish, failed
        self._closing = threading.Event()
        self._next = 0
        self._poses = Poses(true=True)
        self._photos: dict[float, Photo] = {}
        self._words = 0
        self._thread = threading.Thread(target=self._work, name="report", daemon=True)

    def start(self) -> None:
        """Begin to follow the recording."""
        self._thread.start()

    def close(self) -> None:
        """Stop."""
        self._closing.set()
        self._thread.join()

    def _work(self) -> None:
        try:
            self._follow()
        except Exception as error:  # viewers wait for an edition, or for this
            self._failed(error)

    def _follow(self) -> None:
        header = self._growing.so_far().header
        if self._earlier is not None:
            self._forecast = read_forecast(self._earlier, forecast_of(header))
        with recorded_mission(header) as loaded:
            run = RunContents(
                loaded, about_run(header, loaded), estimates=header.backend not in SIMULATORS
            )
            while not self._growing.so_far().content.pieces:
                if not (self._may_wait() if self._growing.under_way else self._more(run, loaded)):
                    return
                self._growing.grow()
            recording = self._growing.so_far(lambda: self._more(run, loaded))
            try:
                for again in rerun(recording, loaded, every_signal=True):
                    if self._closing.is_set():
                        return
                    run.take(again)
            except Exception as error:
                if not self._next:
                    raise
                self._publish(self._last_edition(run, loaded, error))

    def _may_wait(self) -> bool:
        """Wait until the file is to be looked at again; return whether it is."""
        return not self._closing.wait(POLL_S)

    def _more(self, run: RunContents, loaded: LoadedMission) -> bool:
        """Publish what there is, and wait for more; return whether there is more."""
        read = len(self._growing.so_far().content.pieces)
        while not self._closing.is_set():
            under_way, began_s = self._growing.under_way, time.monotonic()
            self._publish(self._edition(run, loaded, under_way=under_way))
            rests_until_s = began_s + (time.monotonic() - began_s) / _SHARE
            while self._may_wait():
                self._growing.grow()
                if time.monotonic() < rests_until_s:
                    continue
                if len(self._growing.so_far().content.pieces) > read:
                    return True
                if self._growing.under_way != under_way:
                    break
                if self._growing.complete:
                    return False
        return False

    def _edition(self, run: RunContents, loaded: LoadedMission, *, under_way: bool) -> Edition:
        recording = self._growing.so_far()
        add_known(self._poses, recording, loaded)
        notices = () if under_way else recording.notices
        run.about = about_run(recording.header, loaded, notices)
        seen = self._poses if self._poses.times_s else None
        report = run.report(seen, under_way=under_way)
        words = [span for lane in report.lanes if lane.name == DETECTOR for span in lane.spans]
        if len(words) != self._words or not under_way:
            self._words = len(words)
            found = photos_of(recording, report.lanes)
            self._photos.update((photo.at_s, photo) for photo in found)
        return self._numbered(report)

    def _last_edition(self, run: RunContents, loaded: LoadedMission, error: Exception) -> Edition:
        """Return what was read before an error, without reading more, with a warning."""
        known = isinstance(error, PirateError)
        why = str(error) if known else f"an internal error, {type(error).__name__}: {error}"
        notice = f"the page ends here, with what could be read: {why}"
        run.about = about_run(self._growing.so_far().header, loaded, [notice])
        seen = self._poses if self._poses.times_s else None
        return self._numbered(run.report(seen, under_way=False))

    def _numbered(self, report: Report) -> Edition:
        gaps = tuple((gap.from_s, gap.until_s) for gap in self._growing.so_far().gaps)
        photos = tuple(self._photos[at_s] for at_s in sorted(self._photos))
        if self._forecast is not None:
            report = with_expectations(report, self._forecast)
        version, self._next = self._next, self._next + 1
        return edition_of(replace(report, photos=photos, gaps=gaps), version)
