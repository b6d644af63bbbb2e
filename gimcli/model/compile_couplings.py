"""Compiler of the actuators that follow others: their couplings and their laws."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from gimcli.mechanism import ConstantLaw, Coupling, Input, InputLaw
from gimcli.model.laws import RunLaw, SummedLaw
from gimcli.model.schema import Actuator, Model


def couplings_of(model: Model, inputs: Sequence[Input], units: Mapping[bool, Any]) -> tuple[Coupling, ...]:
    """Return the couplings of the actuators that follow others, in the order of the file.

    inputs: the actuators with their drawn values. units: one unit of the file in the normal frame, for rotary (True)
    and linear inputs.
    """
    names, found = list(model.actuators), dict[str, Coupling]()

    def coupling(name: str, actuator: Actuator) -> Coupling:
        if name in found:
            return found[name]
        own, other = names.index(name), names.index(str(actuator.follows))
        unit = units[inputs[own].rotary]
        ratio = (1.0 if actuator.ratio is None else actuator.ratio) * (unit / units[inputs[other].rotary])
        phase = actuator.phase * unit if actuator.phase is not None else inputs[own].drawn - ratio * inputs[other].drawn
        found[name] = Coupling(own, ((other, ratio),), phase)
        leader = model.actuators[names[other]]
        if leader.follows is not None:
            found[name] = _through(found[name], coupling(names[other], leader))
        return found[name]

    return tuple(coupling(name, a) for name, a in model.actuators.items() if a.follows is not None)


def _through(outer: Coupling, inner: Coupling) -> Coupling:
    """Return the coupling to the leaders of the leader."""
    ((_, ratio),) = outer.terms
    terms = tuple((actuator, ratio * own) for actuator, own in inner.terms)
    return Coupling(outer.follower, terms, ratio * inner.phase + outer.phase)


def with_laws(inputs: Sequence[Input], couplings: Sequence[Coupling]) -> tuple[Input, ...]:
    """Return the actuators; the laws of followers are those of their leaders, times the ratios.

    Inputs that follow a quantity that is read from the position have a constant law: their values must be solved for.
    """
    timed = list(inputs)
    for coupling in couplings:
        if coupling.reads:
            start = timed[coupling.follower]
            timed[coupling.follower] = replace(start, law=ConstantLaw(start.drawn))
            continue
        law = _law(coupling, [timed[k].law for k, _ in coupling.terms])
        timed[coupling.follower] = replace(timed[coupling.follower], law=law)
    return tuple(timed)


def _law(coupling: Coupling, laws: Sequence[InputLaw]) -> InputLaw:
    ratios = [ratio for _, ratio in coupling.terms]
    runs = [law for law in laws if isinstance(law, RunLaw)]
    if 0 < len(runs) == len(laws) and all(law.profile == runs[0].profile for law in runs):
        start, end = (
            coupling.phase + sum(r * getattr(law, at) for r, law in zip(ratios, laws, strict=True))
            for at in ("start", "end")
        )
        return RunLaw(start, end, runs[0].profile)
    return SummedLaw(tuple(zip(ratios, laws, strict=True)), coupling.phase)
