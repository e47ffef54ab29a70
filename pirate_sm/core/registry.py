"""Registries of named parts of a run, with built-in parts and those of other packages.

A package adds a part by an entry point in its pyproject.toml, which refers to a :class:`Plugin`.
Built-in parts are listed in a table of the same kind of references (docs/decisions).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Generic, NamedTuple, TypeVar, cast

from pirate_sm.core.errors import BackendError, PirateError, UsageError
from pirate_sm.core.on_disk import asks_elsewhere
from pirate_sm.core.spelling import meant

F = TypeVar("F", bound=Callable[..., Any])


@dataclass(frozen=True)
class Plugin(Generic[F]):
    """A part that an entry point refers to.

    Attributes:
        about: One line for ``pirate list``.
        make: Makes the part; the registry's protocol defines its arguments and result. It should
            contain slow imports, so that listing the names stays fast.
    """

    about: str
    make: F


class ListedPart(NamedTuple):
    """One name of a registry.

    Attributes:
        name: The name by which users choose it.
        package: The package that adds it; empty for a built-in part.
        about: Description by its package.
        fault: Why it cannot be used; empty if it can.
    """

    name: str
    package: str
    about: str = ""
    fault: str = ""


class Registry(Generic[F]):
    """Finds the parts of one kind by their names.

    Args:
        kind: What they are, in the singular, and the option that chooses one: ``backend``.
        group: Of the entry points with which other packages add some.
        ours: Where our own are, ``package.module:NAME`` by name. Nobody else can take these names.
        returns: What a function that makes a part must return.
        guards: Guards a part of another package during a run; receives whose part it is, for
            messages, and the part.
    """

    def __init__(
        self,
        kind: str,
        group: str,
        ours: Mapping[str, str],
        returns: type,
        guards: Callable[[str, Any], Any] | None = None,
    ) -> None:
        self._kind = kind
        self._guards = guards
        self._group = group
        self._returns = returns
        self._ours = {name: EntryPoint(name, value, group) for name, value in ours.items()}

    def find(self, name: str) -> F:
        """Return the function that makes the part of this name.

        That of another package raises a ``BackendError`` for whatever goes wrong in it, except
        for the errors of this package.

        Raises:
            UsageError: The name is unknown, or its package cannot be used.
        """
        point = self._ours.get(name)  # built-in parts need no search of entry points
        if point is None:
            point = self._others.get(name)
        if point is None:
            raise UsageError(f"there is no {self._kind} '{name}'; {meant(name, self.names)}")
        if name not in self._ours:
            asks_elsewhere()  # the code of another package may look at anything
        try:
            make = self._load(point).make
        except UsageError as error:
            raise UsageError(f"the {self._kind} '{name}' cannot be used: {error}") from error
        return make if name in self._ours else self._guarded(make, point)

    def package_of(self, name: str) -> str:
        """Return the package that adds the name; empty for a built-in part."""
        return "" if name in self._ours else package_name(self._others[name])

    @property
    def names(self) -> list[str]:
        """Return all names in alphabetical order."""
        return sorted({*self._ours, *self._others})

    def listed(self) -> Iterator[ListedPart]:
        """Yield every name with its description, also parts that cannot be used.

        A package whose import fails is reported and does not affect the others.
        """
        for name in self.names:
            point = self._ours.get(name) or self._others[name]
            try:
                yield ListedPart(name, self.package_of(name), self._load(point).about)
            except UsageError as error:
                yield ListedPart(name, self.package_of(name), fault=str(error))
        for point in self._taken:
            yield ListedPart(point.name, package_name(point), fault="the name is taken")

    def forget(self) -> None:
        """Discard the cached entry points; the next access searches for them again."""
        self.__dict__.pop("_found", None)
        self.__dict__.pop("_others", None)

    @cached_property
    def _found(self) -> list[EntryPoint]:
        return points_of(self._group)

    @cached_property
    def _others(self) -> dict[str, EntryPoint]:
        first = {point.name: point for point in reversed(self._found)}
        return {name: point for name, point in first.items() if name not in self._ours}

    @property
    def _taken(self) -> list[EntryPoint]:
        return [point for point in self._found if self._others.get(point.name) is not point]

    def _load(self, point: EntryPoint) -> Plugin[F]:
        """Return the part that an entry point refers to.

        Raises:
            UsageError: The import fails, or the object is no part; the message names the package.
        """
        try:
            plugin = point.load()
        except (Exception, SystemExit) as error:  # imports of other packages may raise anything
            if point.name in self._ours:
                raise
            what = f"{point.value} fails with {type(error).__name__}: {error}"
            raise UsageError(f"package {package_name(point)}: {what}") from error
        if not isinstance(plugin, Plugin):
            found = f"{point.value} is of type {type(plugin).__name__}"
            raise UsageError(
                f"package {package_name(point)}: {found}, expected a pirate_sm.plugins.Plugin"
            )
        return plugin

    def _guarded(self, make: F, point: EntryPoint) -> F:
        """Return the function of another package so that its faults are said to be its own."""
        what, where = f"the {self._kind} '{point.name}'", f"{package_name(point)}: {point.value}"
        whose = f"{what} cannot be used: package {where}"

        def guarded(*arguments: Any, **options: Any) -> Any:
            try:
                made = make(*arguments, **options)
            except PirateError:
                raise
            except (Exception, SystemExit) as error:
                fault = f"{type(error).__name__}: {error}"
                raise BackendError(f"{whose} fails with {fault}") from error
            if not isinstance(made, self._returns):
                expected, found = self._returns.__name__, type(made).__name__
                raise BackendError(f"{whose} returns a value of type {found}, expected {expected}")
            return made if self._guards is None else self._guards(f"{what} (package {where})", made)

        return cast(F, guarded)


def points_of(group: str) -> list[EntryPoint]:
    """Return the entry points of packages, in an order independent of the installation."""
    return sorted(entry_points(group=group), key=lambda each: (each.name, package_name(each)))


def package_name(point: EntryPoint) -> str:
    """Return the name of the package that has the entry point."""
    return point.dist.name if point.dist is not None else "unknown"
