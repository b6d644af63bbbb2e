"""Models whose small vibrations have closed forms."""

from __future__ import annotations

LAGUERRE = {
    2: [0.585786437626905, 3.414213562373095],
    3: [0.4157745567834791, 2.294280360279042, 6.289945082937479],
    4: [0.3225476896193923, 1.745761101158347, 4.536620296921128, 9.395070912301133],
}
"""Zeros of the Laguerre polynomials: omega^2 L/g of a hanging chain of equal point masses on equal massless links."""

SLIDER_CRANK = """
nodes: {O: [0, 0], A: [0.05, 0.08660254037844386], B: [0.3372281323269014, 0], G: [1, 0]}
ground: [O, G]
links: {crank: [O, A], rod: [A, B]}
prismatic: {guide: {node: B, guide: [O, G]}}
actuators: {motor: {pivot: O, arm: A}}
masses: {crank: {mass: 1e-12, inertia: 0.01, centre: [0, 0]}, B: 2}
springs: {s: {nodes: [O, B], stiffness: 800}}
"""


def chain(n, mass="point"):
    """Return the text of n equal links of length 1 hanging in a line; each input is relative to the link before."""
    nodes = ", ".join(f"N{k}: [0, {-k}]" for k in range(n + 1))
    links = ", ".join(f"l{k}: [N{k - 1}, N{k}]" for k in range(1, n + 1))
    references = ["", *(f", reference: N{k}" for k in range(n - 1))]
    drives = ", ".join(f"q{k}: {{pivot: N{k - 1}, arm: N{k}{references[k - 1]}, free: true}}" for k in range(1, n + 1))
    points = ", ".join(f"N{k}: 1" for k in range(1, n + 1))
    bars = ", ".join(f"l{k}: {{mass: 1, inertia: {1 / 12!r}, centre: [0.5, 0]}}" for k in range(1, n + 1))
    return (
        f"nodes: {{{nodes}}}\nground: [N0]\nlinks: {{{links}}}\nactuators: {{{drives}}}\n"
        f"masses: {{{points if mass == 'point' else bars}}}\ngravity: [0, -9.81]\n"
    )


def geared_pendulums(ratio, coupling):
    """Return the text of two hanging bars of 1 m, 1 kg and 0.6 m, 0.5 kg; the second turns `ratio` times as far."""
    return f"""
nodes: {{O: [0, 0], P: [3, 0], A: [0, -1], B: [3, -0.6]}}
ground: [O, P]
links: {{one: [O, A], two: [P, B]}}
actuators:
  q: {{pivot: O, arm: A, free: true}}
  {f"r: {{pivot: P, arm: B, follows: q, ratio: {ratio}, phase: {-90 + 90 * ratio}}}" * (coupling == "follows")}
{f"gears: {{mesh: {{members: [one, two], pivots: [O, P], ratio: {-ratio}}}}}" * (coupling == "gears")}
masses: {{one: {{mass: 1, inertia: {1 / 12!r}}}, two: {{mass: 0.5, inertia: {0.5 * 0.36 / 12!r}}}}}
gravity: [0, -9.81]
"""
