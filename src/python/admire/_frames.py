"""Data frames, datasets and plots of columns with units."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pandas
    import xarray

Column = NDArray[np.float64]


def needed(module: str, of: str, extra: str) -> Any:
    """Import an optional module.

    Parameters
    ----------
    module : str
        Name of the module.
    of : str
        Method that needs it, for the message.
    extra : str
        Extra of this package that installs it.

    Raises
    ------
    ImportError
        If the module is not installed; the message says how to install it.
    """
    import importlib

    try:
        return importlib.import_module(module)
    except ImportError as error:
        package = module.split(".")[0]
        raise ImportError(f"{of} needs {package}; install it by: pip install admire[{extra}]") from error


def time_of(names: Iterable[str]) -> str | None:
    """Return the name of the time column; ``None`` if there is none."""
    return next((name for name in names if name.lower() in ("time", "time.time")), None)


def frame(columns: Mapping[str, Column], kinds: list[str], units: Mapping[str, str]) -> "pandas.DataFrame":
    """Return a frame with one row for each step; ``attrs["units"]`` contains the units."""
    pd = needed("pandas", "to_pandas", "pandas")
    made: "pandas.DataFrame" = pd.DataFrame(dict(columns))
    made.insert(0, "step", kinds)
    time = time_of(columns)
    made = made if time is None else made.set_index(time)
    made.attrs["units"] = {name: units.get(name, "") for name in columns}
    return made


def dataset(
    columns: Mapping[str, Column], kinds: list[str], units: Mapping[str, str], title: str
) -> "xarray.Dataset":
    """Return a dataset with the dimension ``step``; time and kind of each step are coordinates."""
    xr = needed("xarray", "to_xarray", "xarray")
    time = time_of(columns)
    variables = {
        name: ("step", values, {"units": units.get(name, "")}) for name, values in columns.items() if name != time
    }
    coordinates: dict[str, Any] = {"kind": ("step", kinds)}
    if time is not None:
        coordinates["time"] = ("step", columns[time], {"units": units.get(time, "")})
    table: "xarray.Dataset" = xr.Dataset(variables, coords=coordinates, attrs={"title": title})
    return table


def axes_for(count: int, ax: Any, of: str) -> list[Any]:
    """Return one axes for each chart: the given ones, or new ones below each other."""
    pyplot = needed("matplotlib.pyplot", of, "plot")
    if ax is None:
        _, made = pyplot.subplots(count, 1, sharex=True, squeeze=False, figsize=(6.4, 1.6 + 2.4 * count))
        return list(made[:, 0])
    given = list(np.atleast_1d(np.asarray(ax, dtype=object)))
    if len(given) != count:
        raise ValueError(f"ax must hold {count} axes, one for each unit or quantity, not {len(given)}")
    return given


def labelled(name: str, unit: str) -> str:
    """Return the label of an axis."""
    return f"{name} [{unit}]" if unit else name


def plot_columns(
    columns: Mapping[str, Column],
    units: Mapping[str, str],
    x: str,
    ax: Any,
    options: Mapping[str, Any],
) -> Any:
    """Plot columns over another column, one chart for each unit.

    Returns
    -------
    matplotlib.axes.Axes or numpy.ndarray of Axes
        A single axes if all columns have the same unit.
    """
    shown = [name for name in columns if name != x]
    if not shown:
        raise KeyError("no column to plot besides the column of the horizontal axis")
    groups: dict[str, list[str]] = {}
    for name in shown:
        groups.setdefault(units.get(name, ""), []).append(name)
    axes = axes_for(len(groups), ax, "plot")
    for own, (unit, names) in zip(axes, groups.items()):
        for name in names:
            own.plot(columns[x], columns[name], **{"label": name, **options})
        own.set_ylabel(labelled(names[0] if len(names) == 1 else "", unit).strip())
        own.legend()
    axes[-1].set_xlabel(labelled(x, units.get(x, "")))
    return axes[0] if len(axes) == 1 else np.array(axes, dtype=object)


def head_and_unit(head: str) -> tuple[str, str]:
    """Split a heading such as ``toe_angle.left [deg]``."""
    name, _, unit = head.partition(" [")
    return name, unit.rstrip("]")


def plot_bars(
    names: Sequence[str],
    values: Sequence[float],
    errors: Sequence[tuple[float, float]] | None,
    label: str,
    ax: Any,
) -> Any:
    """Plot one bar or one point with its interval for each name, the first on top."""
    own = axes_for(1, ax, "plot")[0]
    places = np.arange(len(names))[::-1]
    if errors is None:
        own.barh(places, values)
    else:
        own.errorbar(values, places, xerr=np.array(errors, dtype=float).T.reshape(2, -1), fmt="o", capsize=3)
    own.set_yticks(places, labels=list(names))
    own.set_xlabel(label)
    return own
