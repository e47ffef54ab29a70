"""`pirate campaign`: runs a campaign and prints its table."""

from __future__ import annotations

import json
import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from time import monotonic

from pirate_sm.cli.errors import StoppedError, say
from pirate_sm.cli.options.estimates import CampaignOptions, MarginsOptions
from pirate_sm.cli.output.terminal import progress
from pirate_sm.cli.settings import BUILT_IN, SETTINGS, SettingValue, runs, unusable_runs
from pirate_sm.core import library
from pirate_sm.core.errors import UsageError, not_installed
from pirate_sm.core.on_disk import is_file, is_folder
from pirate_sm.core.spelling import unknown
from pirate_sm.core.visible import visible
from pirate_sm.lab.campaign.campaign_file import read_campaign
from pirate_sm.lab.campaign.conductor import (
    Conductor,
    Progress,
    Which,
    failures,
    record_failures,
    stored_plan,
)
from pirate_sm.lab.campaign.crew import MOST_EACH, connected, most_workers
from pirate_sm.lab.campaign.plan import CampaignPlan, mark_of
from pirate_sm.lab.campaign.result_suite import as_junit
from pirate_sm.lab.campaign.results import CampaignResult, as_text, result_of
from pirate_sm.lab.campaign.store import DamagedMarkError, Store, is_store
from pirate_sm.running.runtime.ending import BY_SIGNAL, Stop

AS_EXPECTED, BELOW = 0, 1

_MOST_NAMES = 3


def run_campaign(options: CampaignOptions) -> int:
    """Run the campaign, print its table and return the exit code.

    Raises:
        LoadError: Everything that is wrong with the files.
        CheckError: A mission is refused.
        UsageError: An argument does not fit, no scheduler answers, or results cannot be kept.
        BackendError: The workers are lost; results so far are kept.
    """
    refuse_unusable(options)
    seeds = None if options.seeds is None else range(options.seeds)
    plan = _chosen(read_campaign(file_of(options.campaign), seeds, check=options.check), options)
    return conduct(plan, options, options.record, chosen=bool(options.cells))


def conduct(
    plan: CampaignPlan,
    options: CampaignOptions | MarginsOptions,
    record: Which,
    *,
    chosen: bool = False,
) -> int:
    """Run a plan, print its table and return the exit code.

    Args:
        plan: The campaign.
        options: Where and how it runs.
        record: Which of its failed runs are repeated with a recording.
        chosen: Whether it has some cells of its file only.
    """
    try:
        with open_results(plan, options, chosen=chosen) as store:
            result = _run(plan, store, options, record)
    except StoppedError as stopped:
        say(str(stopped))
        return stopped.exit_code
    for line in _rendered(result, options.format):
        print(line)
    return AS_EXPECTED if result.good else BELOW


def refuse_unusable(options: CampaignOptions | MarginsOptions) -> None:
    """Refuse before missions are checked, which takes long.

    Raises:
        UsageError: A package is missing that campaigns need, or there cannot be such workers.
    """
    if options.scheduler is not None and options.workers is not None:
        raise UsageError("--scheduler and --workers exclude each other: that cluster has its own")
    for module in ("pyarrow", "distributed"):
        if find_spec(module) is None:
            raise not_installed("a campaign", module, "campaign")
    if options.workers is not None and options.workers > (most := most_workers()):
        raise UsageError(
            f"--workers {options.workers}: at most {most} are started on this machine, "
            f"{MOST_EACH} for each processor; more only take memory"
        )


def file_of(name: str) -> Path:
    """Return the path of a campaign or a mission, of which a shipped one may be named.

    Raises:
        UsageError: There is no such mission.
    """
    return Path(name) if library.is_path(name) else library.find_mission(name)


def _chosen(plan: CampaignPlan, options: CampaignOptions) -> CampaignPlan:
    """Return the plan with the requested cells only."""
    wanted = options.cells or ()
    known = list(dict.fromkeys(each for cell in plan.cells for each in (cell.row, cell.name)))
    if wrong := unknown("there is no cell", wanted, known):
        raise UsageError(wrong)
    cells = tuple(cell for cell in plan.cells if not wanted or {cell.row, cell.name} & {*wanted})
    return replace(plan, cells=cells)


def _is_empty(folder: Path) -> bool:
    """Return whether nothing is in a folder.

    Raises:
        UsageError: It cannot be read.
    """
    try:
        return not any(folder.iterdir())
    except OSError as error:
        raise UsageError(f"'{folder}' cannot be read: {error.strerror}") from None


@contextmanager
def open_results(
    plan: CampaignPlan, options: CampaignOptions | MarginsOptions, *, chosen: bool = False
) -> Iterator[Store]:
    """Yield the store of the results, which is closed when the block ends.

    Raises:
        UsageError: They cannot be kept in that folder.
        StoppedError: A signal has ended it.
    """
    folder = options.output or _usual_folder(plan.name)
    store, described = Store(folder), plan
    if is_store(folder):
        if not options.resume:
            raise UsageError(
                f"there are results in '{folder}' already: continue with --resume, or name another "
                "folder with --output"
            )
        before = _refuse_another(plan, store)
        described = _with_others(plan, before) if chosen and before else plan
    elif is_file(folder):
        raise UsageError(f"'{folder}' is a file: name a folder for the results with --output")
    elif is_folder(folder) and not _is_empty(folder):
        raise UsageError(
            f"'{folder}' is there already and has no results of a campaign: name another folder "
            "with --output"
        )
    store.begin(mark_of(described))
    stops: list[Stop] = []
    try:
        with _terminated_as_by_ctrl_c(stops.append):
            yield store
    except KeyboardInterrupt:
        stop = stops[0] if stops else BY_SIGNAL[signal.SIGINT]
        reason = f"{stop.reason}; results so far are in '{folder}': continue with --resume"
        raise StoppedError(stop._replace(reason=reason)) from None
    finally:
        store.close()


@contextmanager
def _terminated_as_by_ctrl_c(note: Callable[[Stop], None]) -> Iterator[None]:
    """Let SIGTERM do what Ctrl-C does, so that the workers end and the results are kept."""

    def terminate(number: int, _frame: object) -> None:
        note(BY_SIGNAL[signal.Signals(number)])
        signal.raise_signal(signal.SIGINT)

    before = signal.signal(signal.SIGTERM, terminate)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _with_others(plan: CampaignPlan, before: CampaignPlan) -> CampaignPlan:
    """Return the plan, extended by the cells of which a folder has results."""
    chosen = {cell.name: cell for cell in plan.cells}
    cells = [chosen.pop(cell.name, cell) for cell in before.cells]
    return replace(plan, cells=(*cells, *chosen.values()))


def _refuse_another(plan: CampaignPlan, store: Store) -> CampaignPlan | None:
    """Refuse a folder with the results of another campaign, and say which of them do not count.

    Returns:
        The plan of the results that are there; None if they do not count.

    Raises:
        UsageError: It is another one, or its format is that of another version.
    """
    try:
        before = stored_plan(store)
    except DamagedMarkError as error:
        if error.campaign not in (None, plan.name):
            raise _another(store, f"'{error.campaign}'", f"'{plan.name}'") from None
        say(f"warning: {error.problem}: it is rewritten")
        return None
    if before.name != plan.name:
        raise _another(store, *map(_described, (before, plan)))
    if before.version != plan.version:
        say(
            f"warning: results of another version, {before.version}, are in '{store.folder}': "
            "not used"
        )
        return None
    keys = {cell.name: cell.key for cell in before.cells}
    changed = [cell.name for cell in plan.cells if keys.get(cell.name, cell.key) != cell.key]
    if changed:
        say(
            f"warning: files or choices of cells have changed since the results in "
            f"'{store.folder}', which are not used: {_named(changed)}"
        )
    return before


def _another(store: Store, before: str, now: str) -> UsageError:
    return UsageError(
        f"'{store.folder}' has the results of the campaign {before}, and this is {now}: "
        "name another folder with --output"
    )


def _described(plan: CampaignPlan) -> str:
    return f"'{plan.name}' ({_named([cell.name for cell in plan.cells])})"


def _named(cells: Sequence[str]) -> str:
    """Return the first names of some cells."""
    more = f" and {len(cells) - _MOST_NAMES:,} more" if len(cells) > _MOST_NAMES else ""
    return f"{', '.join(cells[:_MOST_NAMES])}{more}"


def results_folder(name: str, found: SettingValue) -> Path:
    """Return the default folder for the results of a campaign, by the setting for recordings."""
    return Path(found.value or SETTINGS["runs"].usual) / f"{name}.campaign"


def _usual_folder(name: str) -> Path:
    """Return the default folder for the results, which is there then if a setting names it.

    Raises:
        LoadError: It cannot be made there.
    """
    found = runs()
    folder = results_folder(name, found)
    if found.value and found.source != BUILT_IN:
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            otherwise = "--output names another folder"
            raise unusable_runs(found, error.strerror or str(error), otherwise) from None
    return folder


def _run(
    plan: CampaignPlan, store: Store, options: CampaignOptions | MarginsOptions, record: Which
) -> CampaignResult:
    """Run what has no result yet, record what failed, and return the result."""
    conductor = Conductor(plan, store)
    for file, why in store.damaged.items():
        say(f"warning: '{file}' is damaged ({why}): runs that are missing are repeated")
    store.set_aside()
    if conductor.goes_on or failures(conductor.results, store, record):
        with (
            connected(plan, options.scheduler, options.workers) as crew,
            _progress(plan, conductor.progress.done) as show,
        ):
            conductor.conduct(crew, show)
            record_failures(conductor.results, store, crew, record)
    return result_of(plan, conductor.results, store.folder, conductor.margins)


@contextmanager
def _progress(plan: CampaignPlan, done_before: int) -> Iterator[Callable[[Progress], None]]:
    """Yield a function that shows on a terminal how far the campaign is."""
    began_s = monotonic()
    with progress(f"campaign {plan.name}") as line:

        def show(now: Progress) -> None:
            line(now.done / max(now.of, 1), now.words(done_before, monotonic() - began_s))

        yield show


def _rendered(result: CampaignResult, form: str) -> Sequence[str]:
    if form == "json":
        return [json.dumps(result.as_data(), indent=1, ensure_ascii=False)]
    if form == "junit":
        return [as_junit(result)]
    return [visible(line) for line in as_text(result).splitlines()]
