"""Results: the document of a command, with its tables, its plots and the uncertainties of its figures."""

from __future__ import annotations

import html
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

# Heading of a column of expanded uncertainties.
_EXPANDED = "± 95 %"
# Units that the caption of a table states for all of its figures.
_UNITS = {"µm", "mm", "µrad", "ppm", "arcsec"}
# Half of a 95 % interval of a normal distribution, in standard deviations.
_FACTOR = 1.959963984540054
# Colours of the report by the index that a curve states: X, Y, Z, a fourth axis, limits, uncompensated, compensated, servo,
# measured.
_COLOURS = ["#b84a00", "#00725a", "#005a9c", "#8c3b74", "#a40e26", "#b84a00", "#005a9c", "#5f6670", "#1f2328"]


@dataclass(frozen=True)
class Figure:
    """A figure with its uncertainty.

    Attributes
    ----------
    name : str
        What the figure is, as the command prints it.
    value : float
        The figure, in `unit`.
    unit : str
        Unit of the value and of its uncertainty; empty for a number without one.
    expanded : float or None
        Half the width of the interval that contains the true value with 95 % probability; None if it is not known.
    """

    name: str
    value: float
    unit: str
    expanded: float | None

    @property
    def u(self) -> float | None:
        """Standard uncertainty: that of a normal distribution with the same interval of 95 %, `expanded` / 1.96."""
        return None if self.expanded is None else self.expanded / _FACTOR

    def interval(self) -> tuple[float, float]:
        """Return the ends of the interval that contains the true value with 95 %.

        Returns
        -------
        tuple of float
            Lower and upper end, in `unit`.

        Raises
        ------
        ValueError
            If the uncertainty is not known.
        """
        if self.expanded is None:
            raise ValueError(f"{self.name}: found no uncertainty, needed one for an interval")
        return self.value - self.expanded, self.value + self.expanded

    def to_ufloat(self) -> Any:
        """Return the figure as a number of the package ``uncertainties``, without correlations to others.

        Returns
        -------
        uncertainties.Variable
            The value with its standard uncertainty, tagged with its name.

        Raises
        ------
        ValueError
            If the uncertainty is not known.
        """
        from uncertainties import ufloat  # type: ignore[import-untyped]

        if self.u is None:
            raise ValueError(f"{self.name}: found no uncertainty, needed one")
        return ufloat(self.value, self.u, tag=self.name)

    def __str__(self) -> str:
        spread = "" if self.expanded is None else f" ± {self.expanded:.2g}"
        return f"{self.value:.6g}{spread} {self.unit}".rstrip()


class Section(Mapping[str, Any]):
    """A part of a result: its fields as attributes and as keys; it cannot be changed."""

    __slots__ = ("_document",)
    # Types of the fields that are sections or tuples of sections.
    _sections: ClassVar[dict[str, type[Section]]] = {}
    _document: dict[str, Any]

    def __init__(self, document: Mapping[str, Any]) -> None:
        object.__setattr__(self, "_document", dict(document))

    def __getitem__(self, key: str) -> Any:
        return self._document[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._document)

    def __len__(self) -> int:
        return len(self._document)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        # A field whose name is a word of Python ends in an underscore: `from_`.
        key = name.removesuffix("_")
        if key in self._document:
            return _viewed(self._document[key], self._sections.get(name, Section))
        # A field that a result can have and that this one has not.
        if any(name in kind.__dict__.get("__annotations__", ()) for kind in type(self).__mro__):
            return None
        needed = ", ".join(self._document)
        raise AttributeError(f"{type(self).__name__}: found no field {name!r}, needed one of {needed}")

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"{type(self).__name__}: {name!r} cannot be set: a result does not change")

    def __delattr__(self, name: str) -> None:
        self.__setattr__(name, None)

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._document]

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self._document,)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self._document!r})"

    def to_dict(self) -> dict[str, Any]:
        """Return the fields as a dictionary: the JSON of the command, and the arrays that only Python has."""
        return dict(self._document)

    @property
    def correlation(self) -> NDArray[np.float64]:
        """Correlation of the terms of a fit, in the order of `covariance.names`; `identify` has one for every angle."""
        return correlation_of(_covariance(self))

    def to_ufloats(self) -> dict[str, Any]:
        """Return the terms of a fit as numbers of the package ``uncertainties``, with their correlations.

        Returns
        -------
        dict of uncertainties.UFloat
            The terms with their standard errors, by name, in the units that `covariance.units` lists.

        Raises
        ------
        ValueError
            If the result, or this section of it, has no covariance.
        """
        from uncertainties import correlated_values

        matrix, own = _covariance(self), self["covariance"]
        return dict(zip(own["names"], correlated_values(own["estimates"], matrix, tags=own["names"])))


def _viewed(value: Any, kind: type[Section]) -> Any:
    """Return a value as attributes show it: sections of a kind, and lists of numbers as arrays that cannot be written."""
    if isinstance(value, dict):
        return kind(value)
    if isinstance(value, list):
        if value and all(isinstance(of, (int, float)) and not isinstance(of, bool) for of in value):
            array = np.array(value)
            array.setflags(write=False)
            return array
        return tuple(_viewed(of, kind) for of in value)
    return value


class _Presentation:
    """What the command prints and its report draws of a result, rendered when it is first asked for."""

    def __init__(self, native: Any) -> None:
        self._native = native

    @cached_property
    def parts(self) -> dict[str, Any]:
        return {} if self._native is None else self._native.parts()

    @cached_property
    def text(self) -> str:
        return "" if self._native is None else self._native.text()

    @cached_property
    def drawn(self) -> list[str]:
        return [] if self._native is None else self._native.figures()

    def __getstate__(self) -> dict[str, Any]:
        return {"parts": self.parts, "text": self.text, "drawn": self.drawn}


class Result(Section):
    """A result: the fields of the command's JSON as attributes, its tables, figures and plots.

    Fields are attributes and keys; `to_dict` returns them as a dictionary. Printed, a result is what the command prints;
    in a notebook it is the table and the figures of the command's report.
    """

    __slots__ = ("_presentation",)
    _presentation: _Presentation

    def __init__(self, document: Mapping[str, Any], presentation: Any = None) -> None:
        super().__init__(document)
        own = presentation if isinstance(presentation, _Presentation) else _Presentation(presentation)
        object.__setattr__(self, "_presentation", own)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self._document, self._presentation)

    @property
    def _parts(self) -> dict[str, Any]:
        return self._presentation.parts

    def __repr__(self) -> str:
        if self._presentation.text:
            return self._presentation.text.rstrip("\n")
        plain = {key: value for key, value in self._document.items() if isinstance(value, (str, int, float, bool))}
        return f"{type(self).__name__}({', '.join(f'{key}={value!r}' for key, value in plain.items())})"

    def _repr_html_(self) -> str:
        if not self._parts:
            return f"<pre>{html.escape(repr(self))}</pre>"
        parts = self._parts
        text = f"<h4>{html.escape(parts['title'])}</h4><p>{html.escape(', '.join(parts['summary']))}</p>"
        if parts["result"]:
            text += f"<p><b>{html.escape(parts['result'])}</b></p>"
        text += "".join(map(_html_table, (of for of in parts["tables"] if of["rows"])))
        return text + "".join(self._presentation.drawn) + "".join(f"<p>{html.escape(note)}</p>" for note in parts["notes"])

    @property
    def tables(self) -> list[str]:
        """Captions of the tables, the most important first: what `to_frame` takes."""
        return [of["caption"] for of in self._parts.get("tables", []) if of["rows"]]

    @property
    def plots(self) -> list[str]:
        """Titles of the plots: what `plot` takes."""
        parts = self._parts
        own = [*parts.get("plots", []), *parts.get("polars", [])] + ([parts["map"]] if parts.get("map") else [])
        return [of["title"] for of in own]

    @property
    def figures(self) -> dict[str, Figure]:
        """Figures with their uncertainties, by the names that the command prints; in the order of its tables."""
        found: dict[str, Figure] = {}
        for table in self._parts.get("tables", []):
            for figure in _figures(table):
                found.setdefault(figure.name, figure)
        return found

    def to_frame(self, table: int | str = 0) -> pandas.DataFrame:
        """Return a table as a data frame, with the numbers at full precision.

        Parameters
        ----------
        table : int or str
            Index or caption of the table; see `tables`.

        Returns
        -------
        pandas.DataFrame
            The table, with the names of its rows as index.

        Raises
        ------
        KeyError
            If there is no such table.
        """
        import pandas as pd

        own = _picked([of for of in self._parts.get("tables", []) if of["rows"]], "caption", table)
        rows = [[_cell(cell) for cell in row] for row in own["rows"]]
        frame = pd.DataFrame(rows, columns=own["header"])
        return frame.set_index(own["header"][0])

    def plot(self, ax: Axes | None = None, *, which: int | str = 0) -> Axes:
        """Draw a plot of the report with matplotlib.

        Parameters
        ----------
        ax : matplotlib.axes.Axes or None
            Where to draw; polar axes for a polar plot. By default, a new figure.
        which : int or str
            Index or title of the plot; see `plots`.

        Returns
        -------
        matplotlib.axes.Axes
            The axes drawn on.

        Raises
        ------
        KeyError
            If there is no such plot.
        ImportError
            Without matplotlib.
        """
        import matplotlib.pyplot as plt

        parts = self._parts
        own = [("plot", of) for of in parts.get("plots", [])] + [("polar", of) for of in parts.get("polars", [])]
        own += [("map", parts["map"])] if parts.get("map") else []
        position = _position([of["title"] for _, of in own], which)
        kind, drawn = own[position]
        if ax is None:
            _, ax = plt.subplots(subplot_kw={"projection": "polar"} if kind == "polar" else {})
        {"plot": _draw_plot, "polar": _draw_polar, "map": _draw_map}[kind](ax, drawn)
        ax.set_title(drawn["title"])
        return ax


class Budgeted(Result):
    """A result whose features state what contributes to their uncertainty, and what to measure for them."""

    __slots__ = ()

    @property
    def budget(self) -> pandas.DataFrame:
        """All contributions, a row each, the largest of a feature first: feature, kind, datums, term, standard_um, share."""
        import pandas as pd

        rows = [
            {"feature": of["feature"], "kind": of["kind"], "datums": ", ".join(of["datums"]), **contribution}
            for of in self._document["features"]
            for contribution in of.get("budget", [])
        ]
        return pd.DataFrame(rows, columns=["feature", "kind", "datums", "term", "standard_um", "share"])

    @property
    def advice_measurements(self) -> pandas.DataFrame:
        """What to measure, a row each: name, minutes, in_task, file; needs `advise=True`."""
        return self._advised("measurements", ["name", "minutes", "in_task", "file"])

    @property
    def advice_after(self) -> pandas.DataFrame:
        """Every characteristic before and after the measurements, µm; needs `advise=True`."""
        columns = ["feature", "kind", "before_um", "after_um", "least_um", "low_um", "high_um", "verdict_before", "verdict_after"]
        return self._advised("features", columns)

    def _advised(self, key: str, columns: list[str]) -> pandas.DataFrame:
        import pandas as pd

        if "advice" not in self._document:
            raise ValueError(f"{type(self).__name__}: found no advice, needed predict with advise=True")
        rows = []
        for of in self._document["advice"][key]:
            ends = of.get("interval_um", {})
            rows.append({**of, "low_um": ends.get("low"), "high_um": ends.get("high")})
        return pd.DataFrame(rows, columns=columns)


def correlation_of(covariance: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the correlation matrix; 0 beside the diagonal for a figure that does not vary."""
    errors = np.sqrt(np.diag(covariance))
    errors[errors == 0.0] = 1.0
    correlation: NDArray[np.float64] = covariance / np.outer(errors, errors)
    np.fill_diagonal(correlation, 1.0)
    return correlation


def _covariance(of: Section) -> NDArray[np.float64]:
    if "covariance" not in of:
        needed = "a result of calibrate_solve, evaluate_points, evaluate_r_test, thermal_fit, friction or ballbar, or an angle of identify"
        raise ValueError(f"{type(of).__name__}: found no covariance, needed {needed}")
    return np.array([list(row) for row in of["covariance"]["matrix"]])


def _position(names: list[str], which: int | str) -> int:
    if isinstance(which, int) and -len(names) <= which < len(names):
        return which
    if which in names:
        return names.index(str(which))
    raise KeyError(f"found {which!r}, needed an index below {len(names)} or one of {names}")


def _picked(of: list[dict[str, Any]], name: str, which: int | str) -> dict[str, Any]:
    return of[_position([own[name] for own in of], which)]


def _cell(cell: Any) -> Any:
    """Return a cell of a table: a number at full precision, text, or None for a dash."""
    if isinstance(cell, dict):
        return cell["value"]
    return None if cell == "–" else cell


def _html_table(table: dict[str, Any]) -> str:
    def row(cells: list[Any], tag: str) -> str:
        texts = (cell["text"] if isinstance(cell, dict) else cell for cell in cells)
        return "<tr>" + "".join(f"<{tag}>{html.escape(text)}</{tag}>" for text in texts) + "</tr>"

    body = "".join(row(cells, "td") for cells in table["rows"])
    return f"<table><caption>{html.escape(table['caption'])}</caption>{row(table['header'], 'th')}{body}</table>"


def _figures(table: dict[str, Any]) -> Iterator[Figure]:
    """Yield the figures of a table: the column before every column of expanded uncertainties."""
    header = table["header"]
    unit_at = header.index("unit") if "unit" in header else None
    of_all = table["caption"].rpartition(", ")[2]
    for at, heading in enumerate(header):
        if heading != _EXPANDED or at == 0:
            continue
        quantity, _, unit = header[at - 1].partition(", ")
        unit = unit or (of_all if of_all in _UNITS else "")
        for row in table["rows"]:
            value, expanded = _cell(row[at - 1]), _cell(row[at])
            if not isinstance(value, float):
                continue
            name = row[0] if quantity in ("value", "measured") else f"{row[0]} {quantity}"
            of = str(_cell(row[unit_at]) or "") if unit_at is not None else unit
            yield Figure(name, value, of, expanded if isinstance(expanded, float) else None)


def _numbers(values: list[float | None]) -> NDArray[np.float64]:
    return np.array([np.nan if value is None else value for value in values], dtype=float)


def _labelled(quantity: str, unit: str) -> str:
    return f"{quantity} in {unit}" if unit else quantity


def _draw_plot(ax: Axes, plot: dict[str, Any]) -> None:
    at = np.array(plot["at"], dtype=float)
    for curve in plot["curves"]:
        values, colour = _numbers(curve["values"]), _COLOURS[curve["colour"] % len(_COLOURS)]
        dashes = "--" if curve["dashed"] else "-"
        if curve["expanded"]:
            ax.errorbar(at, values, yerr=_numbers(curve["expanded"]), color=colour, capsize=2, label=curve["name"])
        elif plot["look"] == "columns":
            ax.bar(at, values, width=0.76, color=colour, alpha=0.7, label=curve["name"])
        elif plot["look"] == "points":
            ax.plot(at, values, ".", color=colour, label=curve["name"])
        else:
            marker = "." if plot["look"] == "dotted" else ""
            ax.plot(at, values, dashes, marker=marker, color=colour, label=curve["name"])
    if plot["limit"] is not None:
        ax.axhline(plot["limit"], color=_COLOURS[4], linestyle="--", label="limit")
    if plot["logarithmic"]:
        ax.set_yscale("log")
    ax.set_xlabel(_labelled(*plot["x"]))
    ax.set_ylabel(_labelled(*plot["y"]))
    ax.legend()


def _draw_polar(ax: Axes, polar: dict[str, Any]) -> None:
    for curve in polar["curves"]:
        colour = _COLOURS[curve["colour"] % len(_COLOURS)]
        ax.plot(np.radians(curve["angle_deg"]), _numbers(curve["um"]), color=colour, linewidth=0.8, label=curve["name"])
    # The circle is at zero, and the deviations are drawn about it.
    reach = max(1e-9, *(np.nanmax(np.abs(_numbers(curve["um"]))) for curve in polar["curves"]))
    ax.set_ylim(-3.0 * reach, 1.2 * reach)
    ax.set_xlabel(f"{polar['axes'][0]} at 0°, deviation in µm")
    ax.legend(loc="lower right")


def _draw_map(ax: Axes, of: dict[str, Any]) -> None:
    [x_low, x_high], [y_low, y_high] = of["ends_mm"]
    rows = np.array([_numbers(row) for row in of["rows"]])
    image = ax.imshow(rows, origin="lower", extent=(x_low, x_high, y_low, y_high), aspect="auto")
    ax.set_xlabel("X in mm")
    ax.set_ylabel("Y in mm")
    ax.figure.colorbar(image, ax=ax, label=of["unit"])
