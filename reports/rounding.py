"""Numbers as they are printed: rounded to their error, with SI spaces.

The error decides the digits by the rule of the Particle Data Group (Review of Particle Physics,
introduction, section 5.3): of its first three digits, 100 to 354 keeps two, 355 to 949 keeps one, 950 to 999
becomes 1000 and keeps two. The value is cut at the same decimal.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

NO_BREAK_SPACE = "\u00a0"
#: Between thousands (SI Brochure, 9th edition, 5.4.4); not to be broken across lines.
THIN_SPACE = "\u202f"
MINUS = "\u2212"
MISSING = "–"

#: No figure is printed with more significant digits than this, however small its error.
MOST_DIGITS = 6
#: Digits of a value whose error is not known.
DIGITS_WITHOUT_ERROR = 3
#: Smaller fractions are what is left of rounding, and are printed as none.
LEAST_FRACTION = 1e-9
#: Half width of the interval printed after ±, in standard errors.
COVERAGE_FACTOR = 2.0


def rounded(value: float, standard_error: float | None) -> tuple[str, str]:
    """Write a value and the half width of its interval (two standard errors) to the same decimal.

    Parameters
    ----------
    value : float, finite
    standard_error : float; None where it is not known, then the second text is empty

    Returns
    -------
    value, half width : str, without unit

    >>> rounded(512.3456, 6.8)
    ('512', '14')
    """
    return rounded_to(value, None if standard_error is None else COVERAGE_FACTOR * standard_error)


def rounded_to(value: float, half_width: float | None) -> tuple[str, str]:
    """Write a value and the half width of its interval to the same decimal; without one the second text is empty."""
    if not half_width:
        return significant(value), "" if half_width is None else "0"
    decimals = min(_decimals_of_error(half_width), _most_decimals(value))
    return fixed(value, decimals), fixed(max(half_width, 10.0**-decimals), decimals)


def significant(value: float, digits: int = DIGITS_WITHOUT_ERROR) -> str:
    """Write a number to so many significant digits, never as a power of ten.

    >>> significant(0.0123456), significant(1234.5), significant(0)
    ('0.0123', '1230', '0')
    """
    return fixed(value, digits - 1 - _exponent(value)) if value else "0"


def fixed(value: float, decimals: int) -> str:
    """Write a number to so many decimals; a negative count rounds to tens, hundreds and so on.

    >>> fixed(12345.678, 1), fixed(12345.678, -2), fixed(-0.04, 1)
    ('12\u202f345.7', '12\u202f300', '0.0')
    """
    text = f"{round(value, decimals) + 0.0:,.{max(decimals, 0)}f}"
    separator = THIN_SPACE if abs(value) >= 10_000 else ""
    return text.replace(",", separator).replace("-", MINUS)


def as_given(number: float) -> str:
    """Write a number that somebody chose, with the digits it was given.

    >>> as_given(500.0), as_given(0.6)
    ('500', '0.6')
    """
    return f"{number:.10g}".replace("-", MINUS)


def count(number: int) -> str:
    """Write a whole number with its thousands apart."""
    return fixed(number, 0)


def percent(fraction: float) -> str:
    r"""Write a fraction in per cent to two significant digits; what rounding left of nothing is 0.

    >>> percent(0.0123), percent(7.4e-16)
    ('1.2\xa0%', '0\xa0%')
    """
    fraction = fraction if abs(fraction) >= LEAST_FRACTION else 0.0
    return f"{significant(100.0 * fraction, 2)}{NO_BREAK_SPACE}%"


def with_unit(number: str, unit: str) -> str:
    """Join a number and its unit by a space that does not break; a number without unit stays alone."""
    return f"{number}{NO_BREAK_SPACE}{unit}" if unit else number


def vector(components: Sequence[float], decimals: int = 2) -> str:
    """Write the components of a point or direction, separated by semicolons."""
    return f";{NO_BREAK_SPACE}".join(fixed(component, decimals) for component in components)


def _decimals_of_error(error: float) -> int:
    exponent = _exponent(error)
    return 1 - exponent if error / 10.0**exponent < 3.545 else -exponent


def _most_decimals(value: float) -> int:
    return MOST_DIGITS - 1 - _exponent(value) if value else MOST_DIGITS


def _exponent(value: float) -> int:
    return math.floor(math.log10(abs(value)))
