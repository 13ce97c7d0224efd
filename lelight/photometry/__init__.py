"""Photometric files: IES LM-63 and EULUMDAT read into one value, checked, drawn, written and measured.

``reading`` (which format) → ``ies``, ``eulumdat`` (one reader a format) → ``photometry`` (the value) →
``zones`` (flux, angles), ``opening`` (projected area), ``findings`` (named rules), ``writing`` (either format).
"""
