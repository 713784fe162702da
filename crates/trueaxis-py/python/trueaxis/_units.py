"""Columns and arrays in the units that functions need: by their names, by ``attrs["units"]``, or as ``pint`` quantities."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from . import Error

# Units by the names that columns and attributes give them, each as (quantity, size).
_LENGTHS = {"mm": 1.0, "um": 1e-3, "µm": 1e-3, "μm": 1e-3, "nm": 1e-6, "cm": 10.0, "m": 1e3, "in": 25.4, "inch": 25.4}
_ANGLES = {"deg": 1.0, "°": 1.0, "rad": 180 / np.pi, "mrad": 0.18 / np.pi, "urad": 1.8e-4 / np.pi, "µrad": 1.8e-4 / np.pi, "arcmin": 1 / 60, "arcsec": 1 / 3600}
_TIMES = {"s": 1.0, "ms": 1e-3, "min": 60.0, "h": 3600.0}
_SPEEDS = {"rpm": 1.0, "hz": 60.0, "Hz": 60.0}
_SIZES = {unit: (quantity, size) for quantity, all_of in enumerate((_LENGTHS, _ANGLES, _TIMES, _SPEEDS)) for unit, size in all_of.items()}
# Temperatures have offsets: what is added to the value to get °C.
_OFFSETS = {"c": 0.0, "C": 0.0, "degC": 0.0, "°C": 0.0, "k": -273.15, "K": -273.15}
# pint's name of a unit.
_PINT = {"c": "degC"}


def in_unit(of: Any, name: str, unit: str) -> Any:
    """Return a quantity or a series with units in ``attrs`` as numbers in `unit`; anything else as it is."""
    if _is_quantity(of):
        try:
            return np.asarray(of.to(_PINT.get(unit, unit)).magnitude)
        except Exception as error:
            raise Error(f"{name}: found {of.units}, needed {unit}") from error
    stated = _stated(of, None)
    return of if stated is None else _converted(of, name, stated, unit)


def frame(of: Any, name: str, forms: Sequence[Sequence[str]]) -> Any:
    """Return a frame with the columns of the forms in the units of their names, made from those of other units; anything else as it is."""
    if _is_quantity(of):
        units = {_parts(column)[1] for column in forms[-1]}
        if len(units) > 1:
            raise Error(f"{name}: found {of.units} for columns in {', '.join(sorted(map(str, units)))}, needed one array for each unit, or a data frame")
        return in_unit(of, name, str(units.pop()))
    if not isinstance(of, dict) and not hasattr(of, "columns"):
        return of
    return _Columns(of, dict.fromkeys(column for form in forms for column in form))


class _Columns(dict):  # type: ignore[type-arg]
    """Columns by name, those that a function needs in the unit of their name."""

    def __init__(self, of: Any, needed: dict[str, None]) -> None:
        keys = {str(column): column for column in (of if isinstance(of, dict) else of.columns)}
        own = {name: of[key] for name, key in keys.items()}
        stated = (getattr(of, "attrs", None) or {}).get("units")
        names = {}
        for column in needed:
            base, needs = _parts(column)
            of_frame = {name: stated.get(name) if isinstance(stated, dict) else stated for name in own if _parts(name)[0] == base}
            units = {name: _stated(own[name], unit) for name, unit in of_frame.items()}
            # A column of the needed name, or else one in another unit, or one whose unit is stated elsewhere.
            others = [name for name, unit in units.items() if needs is not None and (unit is not None or _parts(name)[1] is not None)]
            found = [column] if column in own else others
            if len(found) > 1:
                raise Error(f"columns {' and '.join(found)}: found both, needed one of them, for {column}")
            for name in found:
                names[name] = column
                own[name] = _column(own[name], f"column {name}", name, column, units.get(name))
        super().__init__({names.get(name, name): values for name, values in own.items()})

    @property
    def columns(self) -> list[str]:
        return list(self)


def _parts(column: str) -> tuple[str, str | None]:
    """Return what a column is called without its unit, and the unit."""
    base, _, unit = column.rpartition("_")
    return (base, unit) if base and (unit in _SIZES or unit in _OFFSETS) else (column, None)


def _stated(values: Any, of_frame: str | None) -> str | None:
    """Return the unit that a column states beside its name."""
    if _is_quantity(values):
        return str(values.units)
    attrs = getattr(values, "attrs", None)
    own = attrs.get("units") if isinstance(attrs, dict) else None
    return own if isinstance(own, str) else of_frame


def _is_quantity(of: Any) -> bool:
    return hasattr(of, "magnitude") and hasattr(of, "to")


def _column(values: Any, name: str, column: str, needed: str, stated: str | None) -> Any:
    _, unit = _parts(column)
    _, needs = _parts(needed)
    if needs is None:
        return values
    if _is_quantity(values):
        return in_unit(values, name, needs)
    if stated is not None and unit is not None and _known(stated, name, needs) != _known(unit, name, needs):
        raise Error(f"{name}: found {unit} in its name and {stated} in attrs, needed one unit")
    return _converted(values, name, stated or unit or needs, needs)


def _known(unit: str, name: str, needed: str) -> tuple[int, float]:
    if unit in _OFFSETS:
        return -1, _OFFSETS[unit]
    if unit not in _SIZES:
        raise Error(f"{name}: found unit {unit!r}, needed {needed}")
    return _SIZES[unit]


def _converted(values: Any, name: str, unit: str, needed: str) -> Any:
    (quantity, size), (needs, own) = _known(unit, name, needed), _known(needed, name, needed)
    if quantity != needs:
        raise Error(f"{name}: found {unit}, needed {needed}")
    if size == own:
        return values
    numbers = np.asarray(values)
    # Temperatures differ by an offset, everything else by a factor.
    return numbers + (size - own) if quantity < 0 else numbers * (size / own)
