"""Pipelines: strings of stages that a command runs. They know the physics below and nothing of the command line."""
