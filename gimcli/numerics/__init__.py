"""Methods of numerical mathematics that know nothing of mechanisms."""
