"""The worked example of CIE 190:2010: its luminaire and its table of ratings.

Facts re-entered from the MIT-licensed project ``eulumdat-ugr`` (github.com/123VincentB/eulumdat-ugr), which names
the report as their source. 1000 lm, light output ratio 64.97 %, luminous area 1000 x 316 mm without luminous sides,
luminaires one height apart.
"""

from __future__ import annotations

import numpy as np
from photofiles import ldt


def _table(text: str) -> np.ndarray:
    return np.array([line.split() for line in text.strip().splitlines()], dtype=float)


#: cd/klm in C = 0, 15 ... 90 (rows) and γ = 0, 5 ... 90 (columns); nothing goes up.
INTENSITIES = _table("""
    264 264 258 258 242 216 193 178 158 136 114 92 72 54 44 27 22 14 5
    264 265 257 257 244 218 194 179 160 135 115 94 73 55 44 29 21 14 5
    264 264 258 255 246 223 197 181 162 140 118 99 77 59 43 34 20 13 4
    264 265 260 255 249 232 208 182 167 145 123 105 86 65 47 33 18 12 3
    264 264 262 256 249 238 222 194 171 153 130 111 92 75 55 36 21 8 1
    264 263 261 258 251 240 231 214 189 163 143 119 99 79 61 44 25 8 0
    264 264 260 257 250 240 232 217 204 184 152 125 101 79 60 43 25 9 0
""")

#: Ratings of the 19 rooms: five reflectances crosswise, then endwise.
RATINGS = _table("""
    8.9 10.5 9.3 10.8 11.1 10.7 12.2 11.0 12.5 12.9
    10.5 11.9 10.8 12.2 12.6 12.4 13.8 12.8 14.2 14.5
    11.0 12.3 11.4 12.6 13.0 13.1 14.5 13.5 14.8 15.2
    11.5 12.7 11.9 13.1 13.5 13.6 14.8 14.0 15.2 15.6
    11.7 12.9 12.2 13.3 13.7 13.8 14.9 14.2 15.3 15.7
    12.0 13.2 12.5 13.5 14.0 13.8 15.0 14.3 15.3 15.8
    9.6 11.0 10.0 11.3 11.7 11.0 12.4 11.4 12.7 13.1
    11.4 12.5 11.8 12.9 13.3 13.0 14.1 13.4 14.5 14.9
    12.0 13.0 12.4 13.4 13.9 13.9 14.9 14.3 15.3 15.7
    12.7 13.5 13.1 14.0 14.4 14.5 15.4 15.0 15.8 16.3
    13.0 13.8 13.5 14.2 14.7 14.7 15.5 15.2 16.0 16.4
    13.4 14.1 13.8 14.6 15.0 14.8 15.6 15.3 16.0 16.5
    12.4 13.2 12.8 13.6 14.1 14.0 14.8 14.5 15.3 15.8
    13.2 13.8 13.7 14.3 14.8 14.8 15.4 15.3 15.9 16.4
    13.6 14.2 14.1 14.7 15.2 15.0 15.6 15.5 16.1 16.6
    14.1 14.7 14.6 15.1 15.7 15.2 15.7 15.7 16.2 16.8
    12.4 13.1 12.9 13.6 14.1 14.0 14.8 14.5 15.2 15.7
    13.2 13.8 13.8 14.3 14.8 14.8 15.4 15.3 15.9 16.4
    13.7 14.3 14.3 14.8 15.3 15.1 15.6 15.6 16.1 16.7
""")


def luminaire() -> str:
    """The luminaire as EULUMDAT."""
    return ldt(
        lambda c, gamma: INTENSITIES[round(c / 15), round(gamma / 5)] if gamma <= 90 else 0.0,
        sizes=(1100, 400, 100, 1000, 316, 0, 0, 0, 0),
        lamps=((1, "LED", 1000, "", "", 10),),
        ratio=64.97,
        per_klm=1.0,
    )
