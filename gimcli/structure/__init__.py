"""What can be said of a mechanism without solving it."""
