"""K&C tests of an axle: tables and plots."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ._errors import Complaint
from ._frames import axes_for, head_and_unit, labelled, needed

if TYPE_CHECKING:
    import pandas
    import xarray


def framed(page: str) -> str:
    """Return the HTML that shows a complete page inside a Jupyter notebook."""
    import html

    return f'<iframe srcdoc="{html.escape(page)}" style="width:100%;height:80vh;border:0"></iframe>'


@dataclass(frozen=True)
class AxleTests:
    """Characteristics of an axle under the standard K&C tests. ``values`` is the content of ``kc.json``. Jupyter shows the report."""

    values: dict[str, Any]
    curves_csv: str
    gradients_csv: str
    html: str
    complaints: list[Complaint]

    def curves(self) -> "pandas.DataFrame":
        """Return the curves.

        Returns
        -------
        pandas.DataFrame
            One row for each state of each test. Column names look like ``toe_angle.left [deg]``; ``attrs["units"]`` contains their units.
        """
        found = _table(self.curves_csv)
        found.attrs["units"] = {head: head_and_unit(head)[1] for head in found.columns if " [" in head}
        return found

    def gradients(self) -> "pandas.DataFrame":
        """Return the gradients of each test; the column ``unit`` states the unit of each row."""
        return _table(self.gradients_csv)

    def to_xarray(self, test: str) -> "xarray.Dataset":
        """Return the curves of one test.

        Parameters
        ----------
        test : str
            Name of the test: ``bounce``, ``roll``, ``lateral`` and so on.

        Returns
        -------
        xarray.Dataset
            Variables such as ``toe_angle.left`` over the dimension ``step``, each with its unit. The coordinates are ``value``, the
            variable that the test drives, and ``branch``.

        Raises
        ------
        KeyError
            If the test was not run.
        """
        xr = needed("xarray", "to_xarray", "xarray")
        heads, rows = self._rows(test)
        unit = rows[0][heads.index("value_unit")]
        column = {head: [row[at] for row in rows] for at, head in enumerate(heads)}
        coordinates: dict[str, Any] = {
            "value": ("step", _numbers(column["value"]), {"units": unit}),
            "branch": ("step", column["branch"]),
        }
        variables = {}
        for head in heads:
            name, own = head_and_unit(head)
            if "." in name:
                variables[name] = ("step", _numbers(column[head]), {"units": own})
        table: "xarray.Dataset" = xr.Dataset(variables, coords=coordinates, attrs={"test": test})
        return table

    def plot(
        self,
        characteristics: str | Iterable[str] = ("toe_angle", "camber_angle"),
        *,
        test: str = "bounce",
        ax: Any = None,
        **options: Any,
    ) -> Any:
        """Plot characteristics of both wheels over the variable that a test drives.

        Parameters
        ----------
        characteristics : str or iterable of str
            Names from the guide page ``kc``, such as ``toe_angle`` or ``toe_angle.left``. Each name gets its own chart.
        test : str
            Name of the test.
        ax : matplotlib.axes.Axes or a sequence of them, optional
            Axes to plot into, one for each characteristic; new axes by default.
        **options
            Passed to ``Axes.plot``.

        Returns
        -------
        matplotlib.axes.Axes or numpy.ndarray of Axes
            A single axes if there is one characteristic.

        Raises
        ------
        ImportError
            If matplotlib is not installed.
        KeyError
            If the test was not run, or if it does not have the characteristic.
        """
        names = [characteristics] if isinstance(characteristics, str) else list(characteristics)
        heads, rows = self._rows(test)
        over = _numbers([row[heads.index("value")] for row in rows])
        unit = rows[0][heads.index("value_unit")]
        found: list[list[str]] = []
        for name in names:
            own = [head for head in heads if head_and_unit(head)[0] == name or head.startswith(name + ".")]
            if not own:
                raise KeyError(name)
            found.append(own)
        axes = axes_for(len(names), ax, "plot")
        for own, name, columns in zip(axes, names, found):
            for head in columns:
                values = _numbers([row[heads.index(head)] for row in rows])
                own.plot(over, values, **{"label": head_and_unit(head)[0], **options})
            own.set_ylabel(labelled(name, head_and_unit(columns[0])[1]))
            own.legend()
        axes[-1].set_xlabel(labelled(test, unit))
        return axes[0] if len(axes) == 1 else np.array(axes, dtype=object)

    def _rows(self, test: str) -> tuple[list[str], list[list[str]]]:
        heads, *rows = csv.reader(io.StringIO(self.curves_csv))
        at = heads.index("test")
        own = [row for row in rows if row[at] == test]
        if not own:
            raise KeyError(test)
        return heads, own

    def _repr_html_(self) -> str:
        return framed(self.html)

    def __repr__(self) -> str:
        return f"<admire.AxleTests: {', '.join(sorted(self.values))}>"


def _numbers(cells: list[str]) -> "np.ndarray[Any, np.dtype[np.float64]]":
    return np.array([float(cell) if cell else np.nan for cell in cells])


def _table(text: str) -> "pandas.DataFrame":
    pd = needed("pandas", "the table", "pandas")
    table: "pandas.DataFrame" = pd.read_csv(io.StringIO(text), comment="#")
    return table
