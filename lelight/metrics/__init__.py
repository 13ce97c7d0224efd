"""Figures of merit, one publication a module, each figure with its error and its verdict.

The way through: ``figure`` (value, error, verdict) → ``grid``, ``en12464`` (planes) → ``position``,
``opening``, ``cie117``, ``sweep``, ``exceptional`` (glare from known emitters) → ``brightspots``, ``picture``,
``daylight_glare``, ``zones``, ``distribution`` (from pictures) → ``eye``, ``colour_figures`` →
``glare`` (observers) → ``room`` → ``table``, where all figures meet.
"""
