"""Solution of single positions, and of motions along the laws of the inputs."""
