"""Derivatives of positions by dimensions, the spread within tolerances, and the dimensions with the largest effect."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from gimcli import output
from gimcli.canonical import first_greatest
from gimcli.families.design_sensitivity import QuantitySlopes
from gimcli.families.motion_sensitivity import MotionNumber
from gimcli.families.tolerances import FirstOrderSpread, SampledSpread, first_order_spread
from gimcli.library.record import Records, RowField
from gimcli.library.result import Result
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.model.dimensions import Dimension
from gimcli.motion.motion import Motion
from gimcli.motion.summary import first_columns, status_column
from gimcli.quantities.quantity import Item
from gimcli.rounding import titled
from gimcli.status import Status
from gimcli.table import Column, Table, labelled

DEAD_POINT = (
    "the position is a dead point, or nearly one: the equations do not determine how it depends on the dimensions;"
    " choose another input value"
)

FIRST_ORDER = ("worst", "rss", "sd")
SAMPLED = ("mean_shift", "mean_shift_error", "sampled_sd", "sampled_sd_error", "least", "greatest")
"""Labels of the spreads, in the order of `FirstOrderSpread` and `SampledSpread`."""


class LargestEffect(NamedTuple):
    """The dimension with the largest effect on a quantity."""

    dimension: str
    share: float  # of the variance; NaN without tolerances
    text: str


class SensitivityResult(Result):
    """Derivatives of quantities by dimensions: `derivatives["P.x"]["crank.length"]`, `value["P.x"]`, `status`.

    Of a motion they are arrays (rows,), of a position or a number of the whole motion they are numbers. Units are those
    of the file. `most` names the dimension with the largest effect on each quantity.
    """

    KIND = "sensitivity"

    def __init__(
        self, mechanism: Mechanism, motion: Motion, whole: bool, quantities: Sequence[Item],
        reduced: Sequence[MotionNumber], dimensions: Sequence[Dimension], rows: QuantitySlopes,
        tolerances: FloatArray, distribution: str, fixed: tuple[str, ...], left_out: tuple[str, ...],
    ) -> None:  # fmt: skip
        """Keep what was found.

        `fixed` are the dimensions that redundant constraints fix, `left_out` those with a tolerance that is not in the
        spread.
        """
        self.mechanism, self._motion, self.whole = mechanism, motion, whole
        self._quantities, self._reduced, self._dimensions = tuple(quantities), tuple(reduced), tuple(dimensions)
        self.tolerances, self.distribution, self.fixed, self.left_out = tolerances, distribution, fixed, left_out
        self.sampled: SampledSpread | None = None
        self.seed = 0
        self._values, self._slopes, self.good = rows.values, rows.slopes, rows.good
        if reduced:
            self._reduce(rows)

    def _reduce(self, rows: QuantitySlopes) -> None:
        """Replace the rows by numbers of the whole motion, of its solved rows."""
        solved = self._motion.good
        if solved.any():
            own = QuantitySlopes(rows.values[:, solved], rows.slopes[..., solved], rows.good[solved])
            parts = [one.with_slopes(self._quantities, own) for one in self._reduced]
            self._values = np.array([[value] for value, _ in parts])
            self._slopes = np.stack([slopes for _, slopes in parts])[..., None]
        else:
            shape = len(self._reduced), len(self._dimensions), 1
            self._values, self._slopes = np.full(shape[::2], np.nan), np.full(shape, np.nan)
        numbers = np.concatenate([self._values[:, None], self._slopes], axis=1)
        self.good = np.asarray(np.isfinite(numbers).all(axis=(0, 1)))

    # -- names and units --------------------------------------------------------------------------

    @property
    def by_rows(self) -> bool:
        """Whether there is one value for each row of a motion."""
        return self.whole and not self._reduced

    @property
    def names(self) -> list[str]:
        """Names of the quantities."""
        return [one.kept.text for one in self._reduced] or [item.head.name for item in self._quantities]

    @property
    def units(self) -> list[str]:
        """Units of the quantities."""
        return [one.kept.kind.unit or "" for one in self._reduced] or [item.head.unit for item in self._quantities]

    def _unit_of(self, dimension: Dimension) -> str:
        """Return the unit of a dimension; "" if it has none."""
        known = {"length": self.mechanism.length_unit, "angle": self.mechanism.angle_unit}
        return known.get(dimension.unit, "")

    def _slope_unit(self, quantity: int, dimension: Dimension) -> str:
        """Return the unit of a derivative, such as deg/mm."""
        own, by = (unit if unit != "unit" else "" for unit in (self.units[quantity], self._unit_of(dimension)))
        return f"{own or '1'}/{by}" if by else own

    # -- results ----------------------------------------------------------------------------------

    @cached_property
    def value(self) -> dict[str, Any]:
        """The quantities by name."""
        return {name: self._shaped(row) for name, row in zip(self.names, self._values, strict=True)}

    @cached_property
    def derivatives(self) -> dict[str, dict[str, Any]]:
        """The derivatives by quantity and dimension."""
        names = [one.name for one in self._dimensions]
        return {
            name: {by: self._shaped(row) for by, row in zip(names, rows, strict=True)}
            for name, rows in zip(self.names, self._slopes, strict=True)
        }

    def _shaped(self, row: FloatArray) -> Any:
        return row if self.by_rows else float(row[0])

    @cached_property
    def spread(self) -> FirstOrderSpread | None:
        """The spread to first order (quantities, columns); None without tolerances."""
        if not np.any(self.tolerances > 0.0):
            return None
        return first_order_spread(self._slopes, self.tolerances, self.distribution)

    @property
    def codes(self) -> Any:
        """The status of each row: singular where there is a position but no derivative."""
        bad = self._motion.good & ~self.good if not self._reduced else np.zeros_like(self._motion.good)
        return np.where(bad, int(Status.SINGULAR), self._motion.codes)

    @cached_property
    def status(self) -> Any:
        """The status word; of a motion those of the rows (rows,)."""
        return status_column(self.codes).values if self.by_rows else self._word

    @property
    def reason(self) -> str:
        """Why derivatives are missing; "" if none are."""
        codes = self.codes[self.codes != Status.OK]
        if self._reduced and not len(codes) and not self.good.all():
            undefined = [name for name, row in zip(self.names, self._values, strict=True) if not np.isfinite(row[0])]
            return f"'{undefined[0]}' is not defined at these dimensions" if undefined else f"a row: {DEAD_POINT}"
        if not len(codes):
            return ""
        first = Status(int(codes[0]))
        text = DEAD_POINT if first is Status.SINGULAR else first.plain_text
        return f"{len(codes)} of {len(self.codes)} rows: {text}" if self.whole else text

    @property
    def complete(self) -> bool:
        """Whether all derivatives were found."""
        return not self.reason

    @cached_property
    def effects(self) -> FloatArray:
        """Root-mean-square effect (quantities, dimensions): of the tolerances if there are any, else the derivative."""
        weight = self.tolerances if self.spread is not None else np.ones(len(self._dimensions))
        slopes = self._slopes[..., self.good]
        if not slopes.shape[2]:
            return np.full(slopes.shape[:2], np.nan)
        return np.asarray(np.sqrt(np.mean(slopes**2, axis=2)) * weight)

    @cached_property
    def most(self) -> dict[str, LargestEffect]:
        """The dimension with the largest effect on each quantity; without tolerances, of lengths and parameters."""
        if not self.good.any() or not self._dimensions:
            return {}
        return {name: self._largest(k) for k, name in enumerate(self.names)}

    def _largest(self, k: int) -> LargestEffect:
        effects, name = self.effects[k], self.names[k]
        if self.spread is None:
            inputs = {a.name for a in self.mechanism.actuators}
            sizes = np.array([one.unit != "angle" and one.name not in inputs for one in self._dimensions])
            effects = np.where(sizes, effects, -1.0) if sizes.any() else effects
        first = first_greatest(effects)
        one, average = self._dimensions[first], " (root mean square over the motion)" if self.by_rows else ""
        if effects[first] <= 0.0:
            return LargestEffect(one.name, float("nan"), f"{name}: no dimension has an effect")
        unit = self._slope_unit(k, one)
        if self.spread is None:
            text = f"{name}: {one.name} has the largest effect, {_with_unit(effects[first], unit)}{average}"
            return LargestEffect(one.name, float("nan"), text)
        share = float(1.0 / np.sum((effects / effects[first]) ** 2))
        own = self.units[k]
        allowed = _with_unit(self.tolerances[first], self._unit_of(one))
        text = (
            f"{name}: {one.name} has the largest effect, {100.0 * share:.0f} % of the variance: its tolerance"
            f" ±{allowed} gives ±{_with_unit(effects[first], own)}{average}"
        )
        return LargestEffect(one.name, share, text)

    @cached_property
    def inputs(self) -> dict[str, Any]:
        """The inputs of the rows (rows,), or those of the position, by name in the file's units."""
        return super().inputs if self.whole else self.mechanism.inputs_to_file(self._motion.inputs[:, 0])

    def headline(self) -> str:
        """Return the result in one line."""
        where = f"{self.mechanism.name}, motion in {len(self._motion.time) - 1} steps" if self.whole else ""
        word = f": {self.status}" if not self.by_rows else ""
        return f"{where or titled(self.mechanism, self.inputs)}: derivatives of {', '.join(self.names)}{word}"

    # -- report -----------------------------------------------------------------------------------

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints."""
        given = {
            one.name: {"value": one.value, "unit": self._unit_of(one), "tolerance": float(allowed) or None}
            for one, allowed in zip(self._dimensions, self.tolerances, strict=True)
        }
        texts = {"reason": self.reason, "fixed": list(self.fixed), "tolerances_left_out": list(self.left_out)}
        return {
            "status": self._word, "dimensions": given,
            **({"steps": len(self._motion.time) - 1} if self.whole else {"inputs": self.inputs}),
            **{key: value for key, value in texts.items() if value},
            "quantities": {name: self._quantity_report(k, name) for k, name in enumerate(self.names)},
            **({} if self.sampled is None else {"monte_carlo": {
                "samples": self.sampled.samples, "solved": int(self.sampled.solved.min()), "seed": self.seed,
                "distribution": self.distribution,
            }}),
        }  # fmt: skip

    @property
    def _word(self) -> str:
        """The status word of the first row that has another one than "ok", otherwise "ok"."""
        return next((Status(code).word for code in self.codes.tolist() if code != Status.OK), Status.OK.word)

    def _quantity_report(self, k: int, name: str) -> dict[str, Any]:
        """Return value, derivatives and spread of a quantity; of a motion those with the largest magnitude."""
        return {
            "unit": self.units[k], **self._extreme(self._values[k]),
            "derivatives": {
                one.name: {"unit": self._slope_unit(k, one), **self._extreme(self._slopes[k, n])}
                for n, one in enumerate(self._dimensions)
            },
            **({"largest_effect": self.most[name]._asdict()} if name in self.most else {}),
            **{label: self._extreme(rows) for label, rows in self._spreads(k)},
        }  # fmt: skip

    def _extreme(self, rows: FloatArray) -> dict[str, Any]:
        """Return a number; of a motion the one with the largest magnitude, and the inputs there."""
        if not np.isfinite(rows).any():
            return {"value": None}
        row = first_greatest(np.abs(rows))
        where = {"at": self.mechanism.inputs_to_file(self._motion.inputs[:, row])} if self.by_rows else {}
        return {"value": float(rows[row]), **where}

    def _spreads(self, k: int) -> list[tuple[str, FloatArray]]:
        """Return the spreads of a quantity by their labels."""
        first, sampled = self.spread or (), (self.sampled or ())[2:]
        both = zip(FIRST_ORDER, first, strict=False), zip(SAMPLED, sampled, strict=False)  # of those that are known
        return [(label, own[k]) for known in both for label, own in known]

    # -- table and picture ------------------------------------------------------------------------

    def table(self) -> Table:
        """Return one row for each row of the motion, otherwise one for each quantity and dimension.

        Of a motion the column `P.x/crank.length` is the derivative of P.x by crank.length; P.x.worst, P.x.rss and
        P.x.sd are its spread to first order, the following ones that of random designs.
        """
        return self._rows_table() if self.by_rows else self._list_table()

    def _rows_table(self) -> Table:
        columns = first_columns(self._motion, 0)
        for k, (name, unit) in enumerate(zip(self.names, self.units, strict=True)):
            columns.append(Column(name, self._values[k], unit))
            for n, one in enumerate(self._dimensions):
                columns.append(Column(f"{name}/{one.name}", self._slopes[k, n], self._slope_unit(k, one)))
            columns += [Column(f"{name}.{label}", rows, unit) for label, rows in self._spreads(k)]
        return Table((*columns, status_column(self.codes)))

    def _list_table(self) -> Table:
        pairs = [(k, n) for k in range(len(self.names)) for n in range(len(self._dimensions))]
        slopes, spread = np.array([self._slopes[k, n, 0] for k, n in pairs]), self.spread is not None
        allowed = np.array([self.tolerances[n] for _, n in pairs])
        shares = [self.effects[k, n] ** 2 / np.sum(self.effects[k] ** 2) for k, n in pairs] if spread else []
        return Records(
            RowField("quantity", [self.names[k] for k, _ in pairs], str),
            RowField("dimension", [self._dimensions[n].name for _, n in pairs], str),
            RowField("derivative", slopes, float),
            RowField("unit", [self._slope_unit(k, self._dimensions[n]) for k, n in pairs], str),
            RowField("tolerance", allowed, float if spread else None),
            RowField("effect", np.abs(slopes) * allowed, float if spread else None),
            RowField("share", shares, float if spread else None),
            RowField("status", [self._word] * len(pairs), str),
        ).table()

    def picture(self) -> output.picture.Content | None:
        """Return bars at a position, or graphs over the motion; None if there is nothing to draw."""
        if not self.good.any() or not self._dimensions:
            return None
        title = f"{self.mechanism.name}: effect of the dimensions"
        if not self.by_rows:
            charts = self._bars()
            return output.sensitivity.bar_chart(title, charts) if charts else None
        across = first_columns(self._motion, 0)[1:]
        moving = [column for column in across[1:] if np.ptp(column.values) > 0.0]
        abscissa = moving[0] if len(moving) == 1 else across[0]
        bands = []
        for k, name in enumerate(self.names):
            units = [self._slope_unit(k, one) for one in self._dimensions]
            order = np.argsort(-self.effects[k], kind="stable")
            slopes = {self._dimensions[n].name: (units[n], self._slopes[k, n]) for n in order.tolist()}
            spreads = {label: rows for label, rows in self._spreads(k) if label in ("worst", "rss", "sampled_sd")}
            bands.append(output.sensitivity.Band(name, self.units[k], self._values[k], slopes, spreads))
        return output.sensitivity.sensitivity_graphs(title, abscissa, bands)

    def _bars(self) -> dict[str, list[output.sensitivity.BarLine]]:
        """Return the bars of each quantity: effects of tolerances, else derivatives."""
        found, tolerated = {}, self.spread is not None
        what = "effect of the tolerances" if tolerated else "derivative"
        for k, name in enumerate(self.names):
            own, values = self.units[k], self._slopes[k, :, 0] * (self.tolerances if tolerated else 1.0)
            order = [n for n in np.argsort(-np.abs(values), kind="stable").tolist() if values[n] != 0.0]
            units = [own if tolerated else self._slope_unit(k, one) for one in self._dimensions]
            if order:
                found[labelled(f"{name}, {what}", own if tolerated else "")] = [
                    output.sensitivity.BarLine(
                        self._dimensions[n].name, float(values[n]), _with_unit(values[n], units[n]), units[n]
                    )
                    for n in order
                ]
        return found


def _with_unit(value: float, unit: str) -> str:
    """Return a number with its unit in four digits."""
    text = f"{float(value):.4g}"
    return f"{text} {unit}" if unit not in ("", "unit") else text
