"""Lists of objects in a deck."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from ._frames import needed

if TYPE_CHECKING:
    import pandas

    from ._deck import Deck


class Objects(list[str]):
    """List of addresses of objects in a deck, such as ``BUSHING/1``, in the order of the deck."""

    def __init__(self, deck: "Deck", addresses: Iterable[str]) -> None:
        super().__init__(addresses)
        self._deck = deck

    def to_pandas(self, *arguments: str) -> "pandas.DataFrame":
        """Return a frame with one row for each object.

        Parameters
        ----------
        *arguments : str
            Arguments of the statement, such as ``"K"`` or ``"KT.1"``, one column each. The value is ``None`` if an object lacks it.

        Returns
        -------
        pandas.DataFrame
            The addresses are the index. Numbers are in the deck's units, angles in radians.
        """
        pd = needed("pandas", "to_pandas", "pandas")

        def value(address: str, argument: str) -> Any:
            try:
                return self._deck[f"{address}.{argument}"]
            except KeyError:
                return None

        rows = [[value(address, argument) for argument in arguments] for address in self]
        table: "pandas.DataFrame" = pd.DataFrame(rows, index=list(self), columns=list(arguments))
        return table

    def __reduce__(self) -> tuple[Any, ...]:
        return (Objects, (self._deck, list(self)))

    def __repr__(self) -> str:
        return f"Objects({super().__repr__()})"
