"""Compiler of the laws of motion: from the file's units to rad and lengths of the normal frame."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

from gimcli.mechanism import Input, InputLaw
from gimcli.model.law_ends import increment, run_times
from gimcli.model.laws import PROFILES, PolynomialLaw, RunLaw, Scaled, TableLaw
from gimcli.model.schema import Actuator, Law, Model
from gimcli.model.tables import read_table
from gimcli.model.units import TURN


class LawCompiler:
    """Compiles the laws of the inputs of a model, whose values at the initial coordinates are known."""

    def __init__(self, model: Model, folder: Path, scale: float) -> None:
        """`folder` is that of the tables, `scale` the length of the normal frame in the file's unit."""
        self.model, self.folder = model, folder
        self.turn = TURN[model.units.angle]
        self.units = {True: math.pi / 180.0 if model.units.angle == "deg" else 1.0, False: 1.0 / scale}

    def compile(self, inputs: tuple[Input, ...]) -> tuple[tuple[Input, ...], float]:
        """Return the inputs with their laws, and the duration of the motion [s]; followers have no law of their own."""
        known, drawn = self._duration(), {one.name: one.drawn / self.units[one.rotary] for one in inputs}
        times = run_times(self.model, lambda name, _: drawn[name], known is not None)
        duration = known if known is not None else times[0].seconds if times else None
        laws = [self._law(one, self.model.actuators[one.name], duration) for one in inputs]
        timed = tuple(replace(one, law=law) for one, law in zip(inputs, laws, strict=True))
        return timed, 1.0 if duration is None else duration

    def _duration(self) -> Any | None:
        """Return the duration that the file or a table gives [s]."""
        if self.model.duration is not None:
            return self.model.duration
        for actuator in self.model.actuators.values():
            if actuator.law is not None and actuator.law.profile.table is not None:
                time, _ = read_table(self.folder / actuator.law.profile.table)
                return time[-1] - time[0]
        return None

    def _law(self, one: Input, actuator: Actuator, duration: Any | None) -> InputLaw:
        law, drawn, unit = actuator.law or Law(), one.drawn, self.units[one.rotary]
        if actuator.follows is not None:
            return one.law
        if law.profile.table is not None:
            return Scaled(TableLaw(*read_table(self.folder / law.profile.table)), unit)
        shape: InputLaw = PROFILES.get(law.profile.name, PROFILES["uniform"])
        change = increment(law, self.turn * one.rotary, duration)
        if law.profile.polynomial is not None:
            shape = PolynomialLaw(tuple(law.profile.polynomial))
            if change is None and law.to is None:
                return Scaled(shape, unit)
        start = drawn if law.from_ is None else law.from_ * unit
        if law.to is not None:
            return RunLaw(start, law.to * unit, shape)
        whole = 2.0 * math.pi if one.rotary else 0.0
        return RunLaw(start, start + (whole if change is None else change * unit), shape)
