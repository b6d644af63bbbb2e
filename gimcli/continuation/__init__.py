"""Arc-length continuation of curves of positions, through limits of the input and meetings of branches."""
