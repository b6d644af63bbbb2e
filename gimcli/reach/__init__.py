"""The region that a point reaches, its boundary and its inner singular curves."""
