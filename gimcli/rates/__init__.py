"""Velocities, accelerations and jerks by time, by an input, or along a circuit."""
