"""Pipelines: stages strung together for a command. They know the physics and nothing of the command line."""
