"""A hinged arm with everything that exerts forces: spring, damper, torsional spring, loads, centre of mass."""

STRUT = """
units: {length: mm}
nodes: {A: [0, 0], B: [300, 0], S: [60, 380], E: [180, 0]}
ground: [A, S]
elements:
  arm: {nodes: [A, B, E]}
springs:
  coil: {nodes: [S, E], stiffness: 20000, free: 450}
  bush: {pivot: A, arm: B, stiffness: 10}
dampers:
  shock: {nodes: [S, E], damping: 900}
masses:
  arm: {mass: 4, inertia: 0.05, centre: [100, 20]}
loads:
  tyre: {on: arm, at: [300, 0], force: [0, 3000]}
  side: {on: arm, at: [300, 0], follower: [1500, 0]}
  brake: {on: arm, torque: -5}
actuators:
  travel: {type: rotary, pivot: A, arm: B, law: {by: 90}}
duration: 1
"""
