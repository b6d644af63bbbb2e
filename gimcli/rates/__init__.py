"""Velocities, accelerations and jerks: by the time, by an input, along a circuit."""
