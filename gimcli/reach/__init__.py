"""The workspace of a point: the region or path that it reaches, its boundary and inner singular curves."""
