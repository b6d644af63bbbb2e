"""The live view: a local server shows the motion of a model file, and solves it again when the file is saved."""
