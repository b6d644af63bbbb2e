"""The table of a motion with derivatives of the traced points and of all members."""

from gimcli.quantities.motion_table import motion_table, usual
from gimcli.quantities.state import MotionState
from gimcli.rates.derivatives import TracedRates
from gimcli.rates.member_angles import in_rows


def rated(motion, order, traced=None, angles=in_rows):
    """Return the table; `traced` computes the derivatives, by default without compilation."""
    mechanism = motion.mechanism
    state = MotionState(motion, angles, traced=traced or TracedRates(mechanism, mechanism.traced, order))
    return motion_table(motion, usual(mechanism, None, order), state=state)
