"""The models that are compared."""

from __future__ import annotations

from dataclasses import dataclass

from plumbline.models import CENTRE, get_model


@dataclass(frozen=True)
class Row:
    """One model with some of its coefficients free.

    Attributes:
        name: What it is called in the table.
        model: Name of the model.
        free: Its free coefficients.
    """

    name: str
    model: str
    free: tuple[str, ...]

    @property
    def equals(self) -> tuple[str, ...]:
        """The same in other words."""
        others = get_model(self.model).in_other_words(self.free)
        return (f"{self.model} {', '.join(self.free)}",) if self.name in others else others


ROWS = (
    Row("ptlens b", "ptlens", ("b",)),
    Row("radial:2", "brown", ("k1",)),
    Row("division l1", "division", ("l1",)),
    Row("poly5", "poly5", ("k1", "k2")),
    Row("radial:2,4", "brown", ("k1", "k2")),
    Row("division l1, l2", "division", ("l1", "l2")),
    Row("ptlens a, b, c", "ptlens", ("a", "b", "c")),
    Row("radial:2,4,6", "brown", ("k1", "k2", "k3")),
    Row("ptlens b with centre", "ptlens", ("b", *CENTRE)),
    Row("ptlens with centre", "ptlens", ("a", "b", "c", *CENTRE)),
    Row("radial:2,4,6 with centre", "brown", ("k1", "k2", "k3", *CENTRE)),
    Row("brown", "brown", ("k1", "k2", "k3", "p1", "p2")),
    Row("brown with centre", "brown", ("k1", "k2", "k3", "p1", "p2", *CENTRE)),
)
"""What is compared, simple models first. Models that are the same in other words are one row."""
