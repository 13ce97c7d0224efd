"""Scenes whose light is known on paper: geometry, measuring points and exact values; one problem a module."""
