"""Forces, forward dynamics and reduction to the inputs."""
