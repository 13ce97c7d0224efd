"""Figures of the reports, one a file: values in, SVG bytes out.

They carry numbers and short marks only (A, P1, 3): what users named is set beside them by Typst, which finds
a glyph for it. Nothing here depends on the day or the machine: the same values give the same bytes.
"""
