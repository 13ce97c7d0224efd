"""Spectra: bands that are carried through the scene, and spectra made of them again at planes and eyes."""
