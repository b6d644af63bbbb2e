"""The manual: one page a file, shown by `gim manual` and readable on the web."""
