"""What `gim trace` is asked for beyond coordinates: `--measure` and `--plot`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from gimcli.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from gimcli.measures.record import Record
    from gimcli.mechanism import ComplexArray, Mechanism
    from gimcli.motion.motion import Motion
    from gimcli.table import Column, Table

MEASURE_HELP = (
    "Measures (--measure KIND:ARGS; `--measure help` says more) add columns to the CSV, curves to the PNG and ranges to"
    " the report:\n\n"
    "centre:rod/rocker  instant centre of two members, with its centrodes (frame: the ground)\n\n"
    "curvature:P  signed radius, curvature and centre of curvature of a path\n\n"
    "transmission[:B | :rod/rocker | :A/B/C]  transmission angle, of all output joints or of the one named\n\n"
    "advantage:motor/rocker  mechanical advantage of an output (member, sliding pair, point) over an input\n\n"
    "area:rod  area swept by a member, signed and of the region passed over"
)

MeasureOption = Annotated[
    list[str], typer.Option("--measure", "-m", metavar="KIND:ARGS", help="Measure; may be repeated; help lists them.")
]
PlotOption = Annotated[
    str,
    typer.Option(
        "--plot",
        metavar="QUANTITY,...",
        help="Graphs below the drawing: velocity, acceleration, jerk (of the traced points), omega, alpha (of the"
        " members), or measures. Adds their columns too.",
    ),
]


def tell_measures() -> None:
    """Print the kinds of measures and end."""
    from gimcli.cli.console import print_table
    from gimcli.measures import help_lines

    print_table("Measures", ("write", "to get"), help_lines())
    raise typer.Exit


class Asked:
    """The measures and graphs of one trace."""

    def __init__(self, mechanism: Mechanism, measures: Sequence[str], plot: str, derivatives: int) -> None:
        self.mechanism, self.specs, self.order = mechanism, list(measures), derivatives
        self.plots = list(dict.fromkeys(plot.replace(",", " ").split()))
        self.record: Record | None = None
        if self.plots:
            from gimcli.measures.graphs import ORDERS

            self.order = max(derivatives, *(ORDERS.get(word, 0) for word in self.plots))
        for word in self.plots:
            self._include(word)
        if self.specs:
            from gimcli.measures.record import Record

            self.record = Record(mechanism, self.specs)

    def _include(self, word: str) -> None:
        """Measure what a graph is asked of, unless that is done; refuse what does not exist."""
        from gimcli.measures import KINDS
        from gimcli.measures.graphs import ORDERS
        from gimcli.measures.naming import guess

        if word in ORDERS or any(word in (spec, spec.partition(":")[0]) for spec in self.specs):
            return
        if word.partition(":")[0] not in KINDS:
            raise UsageError(f"--plot {word}: no such quantity; {guess(word, [*ORDERS, *KINDS])}")
        self.specs.append(word)

    def head(self, row: Motion) -> list[Column]:
        """Return the measures' columns for the head of a table."""
        return self.record.head_columns(len(row.time)) if self.record is not None else []

    def columns(self, piece: Motion) -> list[Column]:
        """Return the measures' columns of the next piece of the motion."""
        return self.record.columns(piece) if self.record is not None else []

    def curves(self, motion: Motion) -> dict[str, ComplexArray]:
        """Return the curves that the measures add to the drawing."""
        return self.record.curves(motion) if self.record is not None else {}

    def outlines(self, motion: Motion) -> list[ComplexArray]:
        """Return the areas that the measures add to the drawing."""
        return self.record.outlines(motion) if self.record is not None else []

    def panels(self, motion: Motion) -> dict[str, Table]:
        """Return the graphs: their names, and tables whose first column is the abscissa."""
        from gimcli.measures.graphs import ORDERS, abscissa, measured, quantity
        from gimcli.measures.record import Record
        from gimcli.rates.motion_table import motion_table
        from gimcli.table import Table

        if not self.plots:
            return {}
        record = Record(self.mechanism, self.specs)  # anew: only some rows have been kept
        more, heads = record.columns(motion), record.heads
        specs = [measure.spec for measure in record.measures for _ in measure.heads]
        table, across, panels = motion_table(motion, order=self.order), abscissa(motion), {}
        for word in self.plots:
            if word in ORDERS:
                panels[word] = Table((across, *quantity(self.mechanism, table, word)))
                continue
            own = [k for k, spec in enumerate(specs) if word in (spec, spec.partition(":")[0])]
            for name, group in measured([heads[k] for k in own], [more[k] for k in own]).items():
                panels[f"{name}, {word}" if name in panels else name] = Table((across, *group))
        return panels

    def report(self, motion: Motion) -> dict[str, Any]:
        """Return what the measures tell of the whole motion, for --json."""
        return {"measures": self.record.told(motion)} if self.record is not None else {}

    def tell(self, report: dict[str, Any]) -> None:
        """Print the measures' ranges."""
        from gimcli.cli.console import number, print_table

        rows = []
        for spec, found in report.get("measures", {}).items():
            for name, told in found["columns"].items():
                most = "inf" if told["infinite"] else number(told["greatest"], 8)
                empty = f"{told['empty']} rows empty" if told["empty"] else ""
                rows.append((name, told["unit"].replace("unit", ""), number(told["least"], 8), most, empty))
            if "area" in found:
                told = f"{number(found['area'], 6)} ± {found['error']:.1g}"
                rows.append((f"{spec} (region)", found["unit"], "", told, "passed over by the whole motion"))
            if "worst" in found:
                unit = found["columns"][spec]["unit"]
                rows.append((f"{spec} (nearest to 0 or 180 deg)", unit, number(found["worst"], 8), "", ""))
        if rows:
            print_table("", ("measure", "unit", "least", "greatest", ""), rows, right=(2, 3))
